"""Which way is up, in a paper's frame that is not level.

World axes are those of the paper (and of the camera): z is normal to it. Gravity's frame, with z
straight up, is the paper's turned by the rotation vector l = (l_x, l_y, 0), in axes of the paper:

    up = Exp([l]×) e_z = (sin|l| l_y / |l|,  -sin|l| l_x / |l|,  cos|l|)

and an accelerometer at rest reads g · up. So a positive l_x says that up leans towards -y (the
paper's far edge, +y, is the higher one), a positive l_y that it leans towards +x (the edge at +x is
the lower one). Turning about z would change nothing, so l has two numbers.
"""

from __future__ import annotations

import math

Vector2 = tuple[float, float]
Vector3 = tuple[float, float, float]

UP: Vector3 = (0.0, 0.0, 1.0)
"""Of a frame that is level."""
STEEPEST_RAD = math.pi / 2


def up_direction(level_rad: Vector2) -> Vector3:
    """Return the unit vector against gravity, in the paper's axes; `UP`, exactly, where level.

    Parameters
    ----------
    level_rad : (l_x, l_y), rotation vector from the paper's frame to gravity's, rad
    """
    angle = math.hypot(*level_rad)
    if angle == 0:
        return UP
    part = math.sin(angle) / angle
    return part * level_rad[1], -part * level_rad[0], math.cos(angle)


def from_gravity_frame(vector: Vector3, up: Vector3) -> Vector3:
    """Return a vector of gravity's frame in the paper's axes: Exp([l]×) v.

    That is the least turn that takes e_z to `up`, with k = e_z × up and c = up_z:

        v + k × v + k × (k × v) / (1 + c)
    """
    k = (-up[1], up[0], 0.0)
    once = _cross(k, vector)
    twice = _cross(k, once)
    x, y, z = (v + a + b / (1 + up[2]) for v, a, b in zip(vector, once, twice, strict=True))
    return x, y, z


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def check_level(level_rad: Vector2) -> None:
    """Raise `ValueError` where gravity's frame is turned by a right angle or more."""
    if math.hypot(*level_rad) >= STEEPEST_RAD:
        raise ValueError("expected a frame turned by less than 90 degrees against gravity")
