"""Means and quantiles of numbers that come in parts, in bounded memory.

Of up to `KEPT` numbers they are those of all at once, to the last bit. Of more, a mean is that of
sums, and a quantile is good to a thousandth: numbers are counted by their size.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array

KEPT = 1 << 17
PER_OCTAVE, OCTAVES = 512, 80
"""Bins of a quantile: each 0.14 % wide, from 2⁻⁴⁰ to 2⁴⁰."""


class Mean:
    """The mean of numbers."""

    def __init__(self) -> None:
        self.count = 0
        self._sum, self._parts, self._waiting = 0.0, list[Array](), 0

    def add(self, numbers: Array) -> None:
        """Take more numbers (n,), all finite."""
        self.count += len(numbers)
        self._waiting += len(numbers)
        self._parts.append(numbers)
        if self._waiting > KEPT:
            self._sum += float(np.concatenate(self._parts).sum())
            self._parts, self._waiting = [], 0

    @property
    def value(self) -> float:
        """The mean; NaN of no number."""
        if not self.count:
            return float("nan")
        waiting = np.concatenate([np.zeros(0), *self._parts])
        if self._waiting == self.count:
            return float(waiting.mean())
        return (self._sum + float(waiting.sum())) / self.count


class Quantiles:
    """Quantiles of numbers that are not negative."""

    def __init__(self) -> None:
        self.count = 0
        self._parts: list[Array] = []
        self._counts: NDArray[np.int64] | None = None
        self._sums = np.zeros(PER_OCTAVE * OCTAVES)

    def add(self, numbers: Array) -> None:
        """Take more numbers (n,), all finite."""
        self.count += len(numbers)
        self._parts.append(numbers)
        if self.count > KEPT:
            self._sort_in()

    @property
    def median(self) -> float:
        """The median; NaN of no number."""
        return self._of_all(0.5) if self._counts is None else self._of_bins(0.5)

    def at(self, fraction: float) -> float:
        """Return the quantile of a fraction; NaN of no number."""
        return self._of_all(fraction) if self._counts is None else self._of_bins(fraction)

    def _of_all(self, fraction: float) -> float:
        numbers = np.concatenate([np.zeros(0), *self._parts])
        if not len(numbers):
            return float("nan")
        return float(np.median(numbers) if fraction == 0.5 else np.quantile(numbers, fraction))

    def _sort_in(self) -> None:
        numbers = np.concatenate(self._parts)
        self._parts = []
        with np.errstate(divide="ignore"):
            octave = np.log2(numbers) + OCTAVES / 2
        bins = np.clip(np.floor(PER_OCTAVE * octave), 0, PER_OCTAVE * OCTAVES - 1).astype(int)
        size = PER_OCTAVE * OCTAVES
        counts = np.bincount(bins, minlength=size)
        self._counts = counts if self._counts is None else self._counts + counts
        self._sums += np.bincount(bins, weights=numbers, minlength=size)

    def _of_bins(self, fraction: float) -> float:
        """Return the mean of the bin that holds the quantile."""
        assert self._counts is not None
        bin_ = int(np.searchsorted(np.cumsum(self._counts), fraction * (self.count - 1) + 1))
        return float(self._sums[bin_] / self._counts[bin_])
