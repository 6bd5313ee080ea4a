"""Tables as other people's loggers write them: what their columns, units and times mean."""
