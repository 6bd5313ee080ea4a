"""Which sensors and which estimator should I take?"""
