"""Which sensors, which estimator? One folder a question."""
