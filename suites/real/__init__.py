"""The suite `real`: recordings of a real pen."""
