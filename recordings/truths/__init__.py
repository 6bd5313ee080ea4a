"""What somebody else measured of a pen's motion: read from a file, never shown to an estimator."""
