"""The window's loop in C."""
