"""Pressure above a baseline that drifts.

A pen's pressure sensor creeps: what it reads in the air is not zero and not constant. Its lower
baseline over the past,

    b(t) = min of p(s) over t - window ≤ s ≤ t,

is causal, and right as long as the tip left the paper once in the window.
"""

from __future__ import annotations

import numpy as np

from models.arrays import Array


def above_baseline(time_s: Array, pressure: Array, window_s: float) -> Array:
    """Return pressure (n,) above the lowest of the window behind each instant.

    Parameters
    ----------
    time_s : (n,) increasing, s
    window_s : longer follows a drift less; shorter than a press takes it for the baseline
    """
    first = np.searchsorted(time_s, time_s - window_s, side="left")
    lowest = np.array([pressure[start : k + 1].min() for k, start in enumerate(first)])
    return pressure - lowest
