"""The races: every problem's windows, and a stream for the filters and for what keeps factors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from models.state_space import StateSpaceModel
from suites.speed.contender import Entry, ItemT, RaceOutcome
from suites.speed.contenders import (
    REUSE_CONTENDERS,
    REUSE_HORIZONS,
    WINDOW_CONTENDERS,
    sample_contenders,
    stream_contenders,
)
from suites.speed.cost import WindowCost
from suites.speed.held_rows import HeldRows
from suites.speed.problems import Problem
from suites.speed.rows import Quality, Row, row
from suites.speed.runner import Racer, built, race
from suites.speed.samples import filtered_stream
from suites.speed.windows import SolvedWindow, solved_windows

WARM_UP = 2
"""Windows at the front of a table that do not count."""

Absent = Callable[[Entry[Any], str], object]
"""Called with a contender that is left out, and why."""
Names = Collection[str] | None
"""Of the contenders that race; None lets all race."""


@dataclass(frozen=True)
class StreamPlan:
    """How much of a stream the filters run over.

    Parameters
    ----------
    samples : that are timed
    warm_up : before those, not counted
    runs : how often the whole stream is taken in one call
    """

    samples: int = 1000
    warm_up: int = 50
    runs: int = 20


@dataclass(frozen=True, eq=False)
class RacedProblem:
    """A problem after its race: rows, and the windows that were timed."""

    problem: Problem
    model: StateSpaceModel
    rows: tuple[Row, ...]
    windows: tuple[SolvedWindow, ...]


def race_windows(problem: Problem, absent: Absent, names: Names = None) -> RacedProblem:
    """Race contenders on a problem's windows."""
    count = WARM_UP + problem.windows
    solved = solved_windows(problem, count)
    windows = [each.window for each in solved]
    model, timed = windows[0].model, solved[WARM_UP:]
    racers, share = _raced(_named(WINDOW_CONTENDERS, names), model, windows, WARM_UP, absent)
    window_cost, held = WindowCost(model, problem.horizon), HeldRows(model)

    def quality(i: int, outcome: RaceOutcome) -> Quality:
        assert outcome.trajectory is not None
        window, found = timed[i].window, outcome.trajectory
        cost = window_cost(window, found.states[0], found.noises)
        rolled_out = window_cost.states(window, found.states[0], found.noises)
        return Quality(cost, held.violation(window, rolled_out))

    newest = [each.optimum.newest for each in timed]
    active = active_rows(held, timed) if problem.bounded else None
    rows = tuple(
        row(racer, problem, model, newest, quality, active, core_share=share) for racer in racers
    )
    return RacedProblem(problem, model, rows, tuple(timed))


def active_rows(held: HeldRows, solved: Sequence[SolvedWindow]) -> float:
    """Return how many rows of bounds and inequalities are active in a window's optimum, mean."""
    counts = []
    for each in solved:
        states = each.optimum.trajectory.states
        active = held.active(each.window.measurements, states, each.window.scale)
        counts.append(active.sum())
    return float(np.mean(counts))


def race_filters(
    problem: Problem, plan: StreamPlan, absent: Absent, names: Names = None
) -> tuple[Row, ...]:
    """Race what steps along a stream, then what takes it in one call.

    Parameters
    ----------
    problem : whose recording makes the stream
    """
    model = problem.model
    count = plan.warm_up + plan.samples
    stream = filtered_stream(problem, model, count)
    first, second = (sample.measurement.time_s for sample in stream.samples[:2])
    steps = _named(sample_contenders(second - first), names)
    calls = _named(stream_contenders(count), names)
    live, share = _raced(steps, model, stream.samples, plan.warm_up, absent)
    whole = [stream.whole] * (1 + plan.runs)
    batch, batch_share = _raced(calls, model, whole, 1, absent)
    along, after = stream.reference[plan.warm_up :], [stream.reference[-1]] * plan.runs
    return (
        *(row(racer, problem, model, along, core_share=share) for racer in live),
        *(row(racer, problem, model, after, core_share=batch_share) for racer in batch),
    )


def race_reuse(
    problem: Problem, plan: StreamPlan, absent: Absent, names: Names = None
) -> tuple[Row, ...]:
    """Race passes that keep factors along a stream against full ones, sample by sample.

    Parameters
    ----------
    problem : whose recording makes the stream; factors are kept where its sensors hold all
        states
    """
    model = problem.model
    warm_up = plan.warm_up + max(REUSE_HORIZONS)  # before that the longest window is not full
    stream = filtered_stream(problem, model, warm_up + plan.samples)
    entries = _named(REUSE_CONTENDERS, names)
    racers, share = _raced(entries, model, stream.samples, warm_up, absent)
    along = stream.reference[warm_up:]
    return tuple(row(racer, problem, model, along, core_share=share) for racer in racers)


def _named(entries: Sequence[Entry[ItemT]], names: Names) -> Sequence[Entry[ItemT]]:
    return [entry for entry in entries if names is None or entry.name in names]


def _raced(
    entries: Sequence[Entry[ItemT]],
    model: StateSpaceModel,
    items: Sequence[ItemT],
    warm_up: int,
    absent: Absent,
) -> tuple[list[Racer[ItemT]], float]:
    """Return the racers after their race, and the part of it in which they had a core."""
    racers = built(entries, model, items[0], absent)
    return racers, race(racers, items, warm_up)
