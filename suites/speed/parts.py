"""The study in parts: what is raced in one go, and is kept when it is finished."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from suites.speed.export import problem_arrays
from suites.speed.problems import Problem, find_problem
from suites.speed.rows import Row
from suites.speed.suite import Absent, StreamPlan, few, race_filters, race_reuse, race_windows

STREAM_PROBLEM = "pen15_20"
"""On whose recording the filters run."""
REUSE_PROBLEM = "pen24_60"
"""On whose recording factors are kept: its sensors hold all states, so they are by default."""

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class WindowRace:
    """All contenders on a problem's windows."""

    problem: Problem

    def race(self, absent: Absent) -> tuple[Sequence[Row], Arrays]:
        """Return rows, and the arrays of the problem's file."""
        raced = race_windows(self.problem, absent)
        return raced.rows, problem_arrays(self.problem, raced.windows)


@dataclass(frozen=True)
class FilterRace:
    """What filters, along a stream."""

    plan: StreamPlan

    def race(self, absent: Absent) -> tuple[Sequence[Row], Arrays]:
        """Return rows; no file."""
        return race_filters(find_problem(STREAM_PROBLEM), self.plan, absent), {}


@dataclass(frozen=True)
class ReuseRace:
    """What keeps factors, along a stream."""

    plan: StreamPlan

    def race(self, absent: Absent) -> tuple[Sequence[Row], Arrays]:
        """Return rows; no file."""
        return race_reuse(find_problem(REUSE_PROBLEM), self.plan, absent), {}


Part = WindowRace | FilterRace | ReuseRace


@dataclass(frozen=True, eq=False)
class RacedPart:
    """What became of a part.

    Parameters
    ----------
    rows : one per contender and mode
    arrays : of the problem's file, by name; empty where there is none
    left_out : contender that could not be built → why
    warned : sentences about the race
    """

    rows: tuple[Row, ...]
    arrays: Arrays
    left_out: Mapping[str, str]
    warned: tuple[str, ...]


def parts_of(problems: Sequence[Problem], windows: int | None, plan: StreamPlan) -> list[Part]:
    """Return the parts: a race per problem, then those along streams.

    Parameters
    ----------
    windows : at most so many per problem; all where it is None
    """
    limited = problems if windows is None else [few(problem, windows) for problem in problems]
    return [*map(WindowRace, limited), FilterRace(plan), ReuseRace(plan)]


def race_part(part: Part) -> RacedPart:
    """Race a part in whatever process this is."""
    left_out: dict[str, str] = {}
    with warnings.catch_warnings(record=True) as caught:
        rows, arrays = part.race(left_out.setdefault)
    warned = tuple(dict.fromkeys(str(each.message) for each in caught))
    return RacedPart(tuple(rows), arrays, left_out, warned)
