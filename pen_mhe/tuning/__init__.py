"""Which noise levels fit a recording? Fitted by what a recording says, never by ink or truth."""
