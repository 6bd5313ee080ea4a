"""The window's loop in Python, for machines without a C compiler."""
