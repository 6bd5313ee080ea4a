"""Faults of sensors and stamps: what an estimator makes of them, and whether it says so."""
