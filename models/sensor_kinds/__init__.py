"""Kinds of sensors, a file each: data, and what such a sensor reads."""
