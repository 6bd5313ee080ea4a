"""The cases: every problem's windows, and the streams; who races in each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from suites.speed.contender import Entry
from suites.speed.contenders import (
    REUSE_CONTENDERS,
    WINDOW_CONTENDERS,
    sample_contenders,
    stream_contenders,
)
from suites.speed.problems import PROBLEMS, Problem, find_problem
from suites.speed.races import (
    Absent,
    Names,
    StreamPlan,
    race_filters,
    race_reuse,
    race_windows,
)
from suites.speed.rows import Row

Race = Callable[[Problem, Absent, Names], Sequence[Row]]


@dataclass(frozen=True, eq=False)
class SpeedCase:
    """One race.

    Parameters
    ----------
    problem : whose windows, or whose recording
    entries : who races
    race : all of it → rows
    is_stream : whether samples of a stream are timed, and not windows
    """

    problem: Problem
    entries: Sequence[Entry[Any]]
    race: Race
    is_stream: bool = False

    @property
    def names(self) -> list[str]:
        """The contenders, each once."""
        return list(dict.fromkeys(entry.name for entry in self.entries))

    @property
    def sensors(self) -> str:
        """The sensors of what moves."""
        return "+".join(self.problem.body.config.sensors)

    def with_windows(self, count: int) -> SpeedCase:
        """Return the case with at most so many windows."""
        few = replace(self.problem, windows=min(count, self.problem.windows))
        return replace(self, problem=few)


def _windows(problem: Problem, absent: Absent, names: Names) -> Sequence[Row]:
    return race_windows(problem, absent, names).rows


def _filters(problem: Problem, absent: Absent, names: Names) -> Sequence[Row]:
    return race_filters(problem, StreamPlan(), absent, names)


def _reuse(problem: Problem, absent: Absent, names: Names) -> Sequence[Row]:
    return race_reuse(problem, StreamPlan(), absent, names)


CASES: Mapping[str, SpeedCase] = MappingProxyType(
    {
        **{each.key: SpeedCase(each, WINDOW_CONTENDERS, _windows) for each in PROBLEMS},
        "pen15_stream": SpeedCase(
            find_problem("pen15_20"),
            (*sample_contenders(0.0), *stream_contenders(1)),  # by name: of no stream yet
            _filters,
            is_stream=True,
        ),
        # Its sensors hold all states, so by default factors are kept.
        "pen24_stream": SpeedCase(
            find_problem("pen24_60"), REUSE_CONTENDERS, _reuse, is_stream=True
        ),
    }
)
"""Case → its race. A problem's is its key, under which its file goes, too."""
