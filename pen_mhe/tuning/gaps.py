"""Gaps of a camera, and the elevation in the frames that they withhold."""

from __future__ import annotations

from typing import Any

import numpy as np

from models.arrays import Array

GAPS_S = (2.0, 4.0, 6.0, 8.0, 10.0)
"""How long the camera is withheld, one after the other."""
SEEN_S = 1.0
"""How long it is seen between two gaps."""
FIRST_GAPS = (0, 2, 4)
"""With which gap a pass begins: what one pass sees, another withholds."""


def gap_passes(start_s: float, end_s: float) -> list[list[tuple[float, float]]]:
    """Return for each pass the intervals (from, to) in which the camera is withheld."""
    passes = []
    for first in FIRST_GAPS:
        intervals, at, k = [], start_s, first
        while at < end_s:
            gap = GAPS_S[k % len(GAPS_S)]
            intervals.append((at, at + gap))
            at, k = at + gap + SEEN_S, k + 1
        passes.append(intervals)
    return passes


def camera_elevation(readings: Array, sensor_to_body: Array) -> Array:
    """Return the elevation (n,), rad, of a pen in poses of a target on it.

    Parameters
    ----------
    readings : (n, 6) position, m, and rotation vector, rad, of the target in the world
    sensor_to_body : (3, 3) rotation from target axes to body axes
    """
    from scipy.spatial.transform import Rotation  # slow to import

    axis: Any = Rotation.from_rotvec(readings[:, 3:]).apply(sensor_to_body.T[:, 2])
    return np.asarray(np.arcsin(np.clip(axis[:, 2], -1.0, 1.0)))
