"""The suite `tilt`: fixed-weight fusion, and what a model is worth for a tilt."""
