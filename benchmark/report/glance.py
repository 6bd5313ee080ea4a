"""The answer as one picture: a panel per quantity, a row per choice of sensors, a mark each."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmark.report.matrix import Matrix

EDGE = 5.0
"""Percent of a panel's width that its axis leaves free at either end."""


@dataclass(frozen=True)
class LogAxis:
    """A logarithmic axis: the logarithms of its ends, at least a decade apart."""

    low: float
    high: float

    def at(self, value: float) -> float:
        """Return where a value stands, in percent of the width; an end for one beyond it."""
        if not value > 0 or math.isinf(value):
            return 100 - EDGE if value > 0 else EDGE
        part = (math.log10(value) - self.low) / (self.high - self.low)
        return round(EDGE + (100 - 2 * EDGE) * min(max(part, 0.0), 1.0), 2)

    def ticks(self) -> list[float]:
        """Return its decades; within two of them 1, 2 and 5, as far apart as they can be read."""
        decades = range(math.floor(self.low), math.ceil(self.high) + 1)
        parts = (
            (1,)
            if self.high - self.low > 2
            else (1, 3)
            if self.high - self.low > 1.2
            else (1, 2, 5)
        )
        found = [part * 10.0**k for k in decades for part in parts]
        return [value for value in found if self.low <= math.log10(value) <= self.high]


def axis_of(matrix: Matrix) -> LogAxis:
    """Return the axis that holds every figure of a matrix."""
    ends = [v for row in matrix.cells for cell in row for v in (cell.low, cell.high)]
    logs = [math.log10(v) for v in ends if math.isfinite(v) and v > 0] or [0.0]
    more = max(0.0, 1 - (max(logs) - min(logs))) / 2
    return LogAxis(min(logs) - more, max(logs) + more)
