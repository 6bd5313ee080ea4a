"""How far a recording's stamps are off regular ones, and what noise that makes of its readings.

A reading y(t) that is stamped t + ε errs by ε dy/dt. Stamps of a loop that prints, or in whole
milliseconds, are off by more than an inertial sensor's noise allows for as soon as it is turned.
"""

from __future__ import annotations

import numpy as np

from models.arrays import Array

LONG_S = 0.05
"""Over so long a line is laid to see how fast readings change."""
GAP = 4.0
"""Median intervals from which on neighbours do not count as such."""


def stamp_jitter_s(time_s: Array) -> float:
    """Return the deviation of stamps (n,) about a regular clock, s: 0 for a few.

    Second differences of independent errors have √6 times their deviation; their median does not
    count gaps.
    """
    if len(time_s) < 8:
        return 0.0
    bent = np.diff(time_s, n=2)
    return float(1.4826 * np.median(np.abs(bent - np.median(bent))) / np.sqrt(6))


def change_per_s(time_s: Array, values: Array) -> Array:
    """Return how fast readings (n, n_axes) change, RMS per axis (n_axes,), per s."""
    step = float(np.median(np.diff(time_s)))
    apart = max(1, round(LONG_S / step))
    if len(time_s) <= 2 * apart:
        return np.zeros(values.shape[1])
    sums = np.vstack([np.zeros(values.shape[1]), np.cumsum(values, axis=0)])
    means = (sums[apart:] - sums[:-apart]) / apart
    change, over_s = means[apart:] - means[:-apart], time_s[apart:] - time_s[:-apart]
    n = min(len(change), len(over_s))
    change, over_s = change[:n], over_s[:n]
    near = over_s < GAP * apart * step
    return np.sqrt(np.mean((change[near] / over_s[near, None]) ** 2, axis=0))


def jitter_noise(time_s: Array, values: Array) -> float:
    """Return the deviation that the jitter of stamps (n,) adds to readings (n, n_axes).

    Of the axis that changes most: what one recording turns about may be another axis tomorrow.
    """
    jitter = stamp_jitter_s(time_s)
    return jitter * float(change_per_s(time_s, values).max()) if jitter > 0 else 0.0
