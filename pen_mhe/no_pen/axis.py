"""Which axis of a sensor points along the pen, from tip to top, and how the sensor then sits.

Where nobody says it, `recordings.checks.mountings` tells. About the pen's axis nothing is known:
the sensor is turned as little as can be, and spin counts from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.sensor_kinds.mounted import Matrix3
from models.shown_text import value_text

AXES = ("x", "-x", "y", "-y", "z", "-z")
EXPECTED = f"one of {', '.join(AXES)}, or three numbers with commas"

AnyAxis = str | Sequence[float]
"""``"-x"``, or a direction in the sensor's axes: ``"0.1,0,-0.9"``, or three numbers."""


@dataclass(frozen=True)
class PenAxis:
    """The pen's axis, from tip to top, in a sensor's axes.

    Parameters
    ----------
    name : as in ``--axis``
    direction : unit vector
    """

    name: str
    direction: tuple[float, float, float]

    def elevation_rad(self, up: Array) -> float:
        """Return how high the pen points, rad.

        Parameters
        ----------
        up : (3,) unit vector, in the sensor's axes
        """
        return float(np.arcsin(np.clip(np.dot(self.direction, up), -1, 1)))

    def sensor_to_body(self) -> Matrix3:
        """Return the smallest rotation that turns the axis to the pen's z; about x for -z."""
        a, z = np.array(self.direction), np.array([0.0, 0.0, 1.0])
        cosine = float(a @ z)
        if cosine < -1 + 1e-9:
            return ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
        v = np.cross(a, z)
        K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
        R = np.eye(3) + K + K @ K / (1 + cosine)
        rows = [tuple(float(np.round(e, 9)) + 0.0 for e in row) for row in R]
        return rows[0], rows[1], rows[2]  # type: ignore[return-value]


def read_axis(axis: AnyAxis) -> PenAxis:
    """Return the axis that somebody says.

    Raises
    ------
    InputError
        If it is none.
    """
    parts = axis.strip().split(",") if isinstance(axis, str) else list(axis)
    if len(parts) == 1 and str(parts[0]).strip().removeprefix("+").casefold() in AXES:
        return _along(str(parts[0]).strip().removeprefix("+").casefold())
    try:
        vector = np.array([float(part) for part in parts])
    except (TypeError, ValueError):
        vector = np.zeros(0)
    norm = float(np.linalg.norm(vector)) if len(vector) == 3 else 0.0
    if not (np.isfinite(norm) and norm > 0):
        raise InputError(f"axis {value_text(str(axis))}, expected {EXPECTED}")
    direction = vector / norm
    name = ",".join(f"{each:.4g}" for each in direction)
    return PenAxis(name, (float(direction[0]), float(direction[1]), float(direction[2])))


def axis_along(direction: Array) -> PenAxis:
    """Return the axis of a sensor that a direction (3,) along it is."""
    i = int(np.argmax(np.abs(direction)))
    return _along(("-" if direction[i] < 0 else "") + "xyz"[i])


def next_upright(up: Array, taken: PenAxis) -> PenAxis:
    """Return the axis of a sensor that is nearest to up beside one that is taken.

    Parameters
    ----------
    up : (3,) unit vector, in the sensor's axes
    """
    others = (each for each in map(_along, AXES) if each.name[-1] != taken.name[-1])
    return max(others, key=lambda each: each.elevation_rad(up))


def _along(name: str) -> PenAxis:
    i, sign = "xyz".index(name[-1]), -1.0 if name.startswith("-") else 1.0
    unit = [0.0, 0.0, 0.0]
    unit[i] = sign
    return PenAxis(name, (unit[0], unit[1], unit[2]))
