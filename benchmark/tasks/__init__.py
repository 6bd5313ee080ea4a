"""What the benchmark does and finds, as data: task, outcome, suite, results."""
