"""The suite `classics`: problems of the field, from one file, on every estimator."""
