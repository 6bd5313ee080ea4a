"""The report of a benchmark run, for browsers and for terminals."""
