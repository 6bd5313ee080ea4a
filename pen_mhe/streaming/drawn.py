"""The rows of a long run that a figure draws: all of a short one, else evenly spread ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimation.estimate import EstimateHistory
from estimation.recording import Truth
from estimation.recording_parts import joined_truth

MOST_DRAWN = 50_000
"""Rows that a figure holds: more than it has points across."""


class DrawnRows:
    """Keeps every row of a run and of its truth until they are many, then every second, …"""

    def __init__(self) -> None:
        self._rows, self._true = _Spread(), _Spread()
        self._told: list[EstimateHistory] = []
        self._truth: list[Truth] = []

    def tell(self, told: EstimateHistory) -> None:
        """Take the next rows of the output."""
        self._told.append(told[self._rows.take(len(told))])
        if self._rows.count > MOST_DRAWN:
            self._told = [EstimateHistory.joined(self._told)[self._rows.halve()]]

    def read(self, truth: Truth | None) -> None:
        """Take the truth of the next part."""
        if truth is None:
            return
        self._truth.append(_some(truth, self._true.take(len(truth.time_s))))
        if self._true.count > MOST_DRAWN:
            whole = joined_truth(self._truth)
            assert whole is not None
            self._truth = [_some(whole, self._true.halve())]

    @property
    def history(self) -> EstimateHistory:
        """The rows of the output that are drawn."""
        return EstimateHistory.joined(self._told)

    @property
    def truth(self) -> Truth | None:
        """The truth that is drawn."""
        return joined_truth(self._truth)


class _Spread:
    """Which of the numbers 0, 1, … are kept: multiples of a power of two."""

    def __init__(self) -> None:
        self._step, self._seen, self.count = 1, 0, 0

    def take(self, n: int) -> NDArray[np.intp]:
        """Return which of the next n are kept."""
        rows = np.arange(-self._seen % self._step, n, self._step)
        self._seen, self.count = self._seen + n, self.count + len(rows)
        return rows

    def halve(self) -> NDArray[np.intp]:
        """Return which of those that were kept still are."""
        rows = np.arange(0, self.count, 2)
        self._step, self.count = 2 * self._step, len(rows)
        return rows


def _some(truth: Truth, rows: NDArray[np.intp]) -> Truth:
    return Truth(truth.time_s[rows], truth.names, truth.values[rows])
