"""Rotations in place, where gravity turns exactly as the gyroscope says."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation, RotationSpline

from models.arrays import Array


def swinging(
    seed: int, duration_s: float = 10.0, swing_rad: float = 0.3
) -> tuple[Array, Array, Array]:
    """Times, rates and the direction up in body axes of a smooth random rotation in place."""
    rng = np.random.default_rng(seed)
    knots = np.arange(0, duration_s + 1)
    spline = RotationSpline(knots, Rotation.from_rotvec(rng.normal(0, swing_rad, (len(knots), 3))))
    t = np.sort(rng.uniform(0, duration_s, int(200 * duration_s)))
    return t, spline(t, 1), spline(t).inv().apply([0, 0, 1])
