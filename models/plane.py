"""A plane that may slope, z = height + slope · (x, y): what a tip touches."""

from __future__ import annotations

import casadi as ca

from models.level import Vector2

LEVEL_PLANE: Vector2 = (0.0, 0.0)
"""The slope of a plane that does not."""


def height_over(tip: ca.SX, slope: Vector2) -> ca.SX:
    """Return z - slope · (x, y) of a tip (3,), m: the height at x = y = 0 of its plane."""
    if slope == LEVEL_PLANE:
        return tip[2]
    return tip[2] - slope[0] * tip[0] - slope[1] * tip[1]
