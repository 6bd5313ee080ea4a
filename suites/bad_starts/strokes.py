"""A motion of its own for every seed: rest, then strokes."""

from __future__ import annotations

import math

import numpy as np

from models.minimum_jerk import MinimumJerk
from models.motions import motion_named
from models.random_streams import seed_sequence, stream

FROM_REST = "strokes from rest"
"""A motion of its own for every seed: rest, then minimum-jerk strokes to drawn points."""

REST_S, STROKE_S = 0.2, 0.4
STROKE_TIP_STD_MM = (10.0, 10.0, 4.0)
STROKE_ANGLES_STD_DEG = (8.0, 5.0, 10.0)
"""Of the points: letters, and the turning of a pen that writes."""


def strokes_from_rest(seed: int, duration_s: float = 3.0) -> MinimumJerk:
    """Return a pen that rests for `REST_S` and then moves from one drawn point to the next."""
    n = math.ceil((duration_s - REST_S) / STROKE_S)
    drawn = stream(seed_sequence(seed), "strokes from rest").standard_normal((n, 6))
    away = np.vstack([np.zeros(6), drawn]) * [*STROKE_TIP_STD_MM, *STROKE_ANGLES_STD_DEG]
    held = motion_named("still")
    assert isinstance(held, MinimumJerk)
    return MinimumJerk.model_validate(
        {
            "description": "a pen at rest, then strokes to drawn points",
            "time_s": [REST_S + STROKE_S * k for k in range(n + 1)],
            "tip_mm": away[:, :3].tolist(),
            "angles_deg": (np.degrees(held.angles_rad[0]) + away[:, 3:]).tolist(),
        }
    )
