"""The noise of a sensor in blocks in which it rests: there what it reads is white."""

from __future__ import annotations

import numpy as np

from models.arrays import Array

BLOCK_S = 0.5
FEWEST, BLOCKS = 8, 3
"""Readings in a block, and blocks."""
WHITE = 0.4
"""Mean square of successive differences over twice the variance: 1 for white noise, little for a
hand."""


def noise_at_rest(time_s: Array, values: Array) -> Array | None:
    """Return the standard deviation of a reading at rest (k,); None without a rest.

    Parameters
    ----------
    time_s, values : (n,), (n, k) of complete readings
    """
    block = np.floor((time_s - time_s[0]) / BLOCK_S)
    _, first, count = np.unique(block, return_index=True, return_counts=True)
    found = []
    for start, n in zip(first, count, strict=True):
        here = values[start : start + n]
        if n < FEWEST:
            continue
        variance = here.var(axis=0, ddof=1)
        steps = np.mean(np.diff(here, axis=0) ** 2, axis=0) / 2
        if (steps >= WHITE * variance).all() and (variance > 0).any():
            found.append(variance)
    if len(found) < BLOCKS:
        return None
    quietest = np.sort(np.array(found), axis=0)[: max(BLOCKS, len(found) // 2)]
    return np.asarray(np.sqrt(quietest.mean(axis=0)))
