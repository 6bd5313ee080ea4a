"""The study in parts: what is measured in one go, and is kept when it is finished."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from suites.real_time.deadlines import KINDS, deadline_rows
from suites.real_time.late_times import late_rows
from suites.real_time.reuse import HORIZONS, THRESHOLDS, reuse_rows
from suites.real_time.sample_times import time_rows
from suites.real_time.streams import CASES, available

DEADLINE_CASE, RECORDED_CASE = "pen24", "dpoint-30"


@dataclass(frozen=True)
class ReusePart:
    """Kept factors on one stream with one horizon."""

    case: str
    data: Path | None
    horizon: int
    thresholds: tuple[float, ...]

    def rows(self) -> Sequence[Any]:
        """Measure."""
        stream = CASES[self.case].stream(self.data)
        return reuse_rows(self.case, stream, (self.horizon,), self.thresholds)


@dataclass(frozen=True)
class DeadlinePart:
    """Deadlines of one estimator."""

    case: str
    data: Path | None
    estimator: str
    steps: int

    def rows(self) -> Sequence[Any]:
        """Measure."""
        return deadline_rows(self.estimator, CASES[self.case].stream(self.data), self.steps)


@dataclass(frozen=True)
class TimePart:
    """Time per sample of one stream."""

    case: str
    data: Path | None

    def rows(self) -> Sequence[Any]:
        """Measure."""
        return time_rows(CASES[self.case].stream(self.data))


@dataclass(frozen=True)
class LatePart:
    """Time per sample of one stream, its frames at their capture and as they arrive."""

    case: str
    data: Path | None

    def rows(self) -> Sequence[Any]:
        """Measure."""
        return late_rows(CASES[self.case].stream(self.data))


Part = ReusePart | DeadlinePart | TimePart | LatePart
PARTS: dict[str, type[Part]] = {
    "reuse": ReusePart,
    "deadlines": DeadlinePart,
    "times": TimePart,
    "late": LatePart,
}
"""Name in ``real_time.json`` → parts whose rows stand there."""
RECORDED = (TimePart, LatePart)
"""Of `RECORDED_CASE` only."""


def parts_of(
    data: Path | None,
    steps: int,
    horizons: Sequence[int] = HORIZONS,
    thresholds: Sequence[float] = THRESHOLDS,
) -> list[Part]:
    """Return all parts for which there are recordings.

    Parameters
    ----------
    data : folder of recordings; None where there is none
    steps : by the clock, per estimator
    horizons, thresholds : of `suites.real_time.reuse.reuse_rows`
    """
    cases = available(data)
    read = {name: data if case.is_real else None for name, case in cases.items()}
    chosen = tuple(thresholds)
    return [
        *(ReusePart(name, read[name], N, chosen) for name in cases for N in horizons),
        *(DeadlinePart(DEADLINE_CASE, read[DEADLINE_CASE], name, steps) for name in KINDS),
        *(kind(name, read[name]) for kind in RECORDED for name in cases if name == RECORDED_CASE),
    ]


def run_part(part: Part) -> Sequence[Any]:
    """Measure a part; returns its rows."""
    return part.rows()
