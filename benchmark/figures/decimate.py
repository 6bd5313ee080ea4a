"""Fewer points of a long curve, with its extremes and its gaps kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array

LIMIT = 800


def decimate(*curves: Array, limit: int = LIMIT) -> NDArray[np.int64]:
    """Return indices, ascending, of the points to draw of curves that share an x axis.

    The points are cut into equal bins; of every bin the smallest and the largest value of
    every curve stay, and of every gap its two ends. The first and last point stay too.

    Parameters
    ----------
    curves : (n,) each; a point is in a gap where one of them is not finite. A path on paper
        gives both its coordinates
    limit : about as many points remain, gaps aside; more show more detail in a zoom, and
        make the page larger. A curve of at most so many points stays whole
    """
    n = len(curves[0])
    if n <= limit:
        return np.arange(n)
    table = np.asarray(curves, dtype=float)
    seen = np.isfinite(table).all(axis=0)
    keep = np.zeros(n, dtype=bool)
    keep[[0, -1]] = True
    # A point on either side of each change between gap and curve.
    change = np.flatnonzero(np.diff(seen))
    keep[change] = keep[change + 1] = True
    bins = max(limit // (2 * len(curves)), 1)
    for part in np.array_split(np.flatnonzero(seen), bins):
        if len(part):
            values = table[:, part]
            keep[part[values.argmin(axis=1)]] = True
            keep[part[values.argmax(axis=1)]] = True
    return np.flatnonzero(keep)
