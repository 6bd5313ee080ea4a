"""Even sampling: what differentiators and integrations here take for granted, checked once."""

from __future__ import annotations

import numpy as np

from models.arrays import Array
from models.errors import InputError

UNEVENNESS = 0.05
"""Part of the step by which single steps may differ: time stamps jitter."""


def even_step(time_s: Array) -> float:
    """Return the step (s) of even samples at times (n,), at least two.

    Raises
    ------
    InputError
        If there are fewer, or a step differs from the mean by more than `UNEVENNESS`.
    """
    if len(time_s) < 2:
        raise InputError(f"got {len(time_s)} samples, expected at least 2 to have a step")
    steps = np.diff(time_s)
    mean = float(steps.mean())
    away = np.abs(steps - mean)
    if not mean > 0 or not (away <= UNEVENNESS * mean).all():
        row = int(np.argmax(away)) + 1
        raise InputError(
            f"step to sample {row} is {steps[row - 1]:g} s, mean step {mean:g} s, "
            "expected even samples"
        )
    return mean
