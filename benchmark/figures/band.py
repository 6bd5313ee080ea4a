"""What surrounds a line: a band, of ±2 standard deviations or its own, and error bars."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmark.figures.figure import Line
from models.arrays import Array

SIGMAS = 2.0
LOG_FLOOR = 0.1
"""Part of a line's value that its band reaches down to on a logarithmic axis, where it ends at or
below zero."""


@dataclass(frozen=True, eq=False)
class Band:
    """A band: its lower and upper end (n,) over x (n,); not finite in gaps."""

    x: Array
    low: Array
    high: Array

    def take(self, index: NDArray[np.int64]) -> Band:
        """Return the band at some of its points."""
        return Band(self.x[index], self.low[index], self.high[index])

    def stretches(self) -> Iterator[Band]:
        """Yield its parts without gaps."""
        seen = np.isfinite(self.x) & np.isfinite(self.low) & np.isfinite(self.high)
        for part in np.split(np.arange(len(seen)), np.flatnonzero(np.diff(seen)) + 1):
            if len(part) and seen[part[0]]:
                yield self.take(part)


def band(line: Line, y_log: bool = False) -> Band | None:
    """Return the band of a line, ±2σ unless it has its own; None where it has neither."""
    x, y = (np.asarray(values, dtype=float) for values in (line.x, line.y))
    if line.band is not None:
        low, high = (np.asarray(end, dtype=float) for end in line.band)
    elif line.std is not None:
        low, high = (y + sign * SIGMAS * np.asarray(line.std, dtype=float) for sign in (-1, 1))
    else:
        return None
    if y_log:
        low = np.where(low > 0, low, LOG_FLOOR * y)
    return Band(x, low, high)


def interval_lengths(line: Line) -> tuple[Array, Array] | None:
    """Return how far the error bars (n,) reach below and above the line; None without any.

    Zero, so no bar, on a side whose end is not given or not finite.
    """
    if line.low is None and line.high is None:
        return None
    y = np.asarray(line.y, dtype=float)
    below, above = np.zeros_like(y), np.zeros_like(y)
    with np.errstate(invalid="ignore"):
        if line.low is not None:
            below = y - np.asarray(line.low, dtype=float)
        if line.high is not None:
            above = np.asarray(line.high, dtype=float) - y
    return tuple(np.where(np.isfinite(side), np.maximum(side, 0), 0.0) for side in (below, above))  # type: ignore[return-value]
