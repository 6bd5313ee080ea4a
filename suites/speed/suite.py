"""The suite: every problem's windows, and a stream for the filters and for what keeps factors."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

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
from suites.speed.verdicts import LEAST_SHARE
from suites.speed.windows import SolvedWindow, SpeedWindow, solved_windows

WARM_UP = 2
"""Windows at the front of a table that do not count."""

Absent = Callable[[str, str], object]
"""Called with the name of a contender that is left out, and why."""


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


def race_windows(
    problem: Problem,
    absent: Absent,
    entries: Sequence[Entry[SpeedWindow]] = WINDOW_CONTENDERS,
) -> RacedProblem:
    """Race all contenders on a problem's windows."""
    count = WARM_UP + problem.windows
    solved = solved_windows(problem, count)
    windows = [each.window for each in solved]
    model, timed = windows[0].model, solved[WARM_UP:]
    racers, share = _raced(problem.key, entries, model, windows, WARM_UP, absent)
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


def race_filters(problem: Problem, plan: StreamPlan, absent: Absent) -> tuple[Row, ...]:
    """Race what steps along a stream, then what takes it in one call.

    Parameters
    ----------
    problem : whose recording makes the stream
    """
    model = problem.model
    count = plan.warm_up + plan.samples
    stream = filtered_stream(problem, model, count)
    first, second = (sample.measurement.time_s for sample in stream.samples[:2])
    steps, calls = sample_contenders(second - first), stream_contenders(count)
    key = f"{problem.name} stream"
    live, share = _raced(key, steps, model, stream.samples, plan.warm_up, absent)
    whole = [stream.whole] * (1 + plan.runs)
    batch, batch_share = _raced(f"{key}, batch", calls, model, whole, 1, absent)
    along, after = stream.reference[plan.warm_up :], [stream.reference[-1]] * plan.runs
    return (
        *(row(racer, problem, model, along, core_share=share) for racer in live),
        *(row(racer, problem, model, after, core_share=batch_share) for racer in batch),
    )


def race_reuse(problem: Problem, plan: StreamPlan, absent: Absent) -> tuple[Row, ...]:
    """Race passes that keep factors along a stream against full ones, sample by sample.

    Parameters
    ----------
    problem : whose recording makes the stream; factors are kept where its sensors hold all
        states
    """
    model = problem.model
    warm_up = plan.warm_up + max(REUSE_HORIZONS)  # before that the longest window is not full
    stream = filtered_stream(problem, model, warm_up + plan.samples)
    key = f"{problem.name} stream, reuse"
    racers, share = _raced(key, REUSE_CONTENDERS, model, stream.samples, warm_up, absent)
    along = stream.reference[warm_up:]
    return tuple(row(racer, problem, model, along, core_share=share) for racer in racers)


def few(problem: Problem, windows: int) -> Problem:
    """Return the problem with at most so many windows."""
    return replace(problem, windows=min(windows, problem.windows))


def _raced(
    key: str,
    entries: Sequence[Entry[ItemT]],
    model: StateSpaceModel,
    items: Sequence[ItemT],
    warm_up: int,
    absent: Absent,
) -> tuple[list[Racer[ItemT]], float]:
    """Return the racers after their race, and the part of it in which they had a core."""
    racers = built(entries, model, items[0], absent)
    share = race(racers, items, warm_up)
    if share < LEAST_SHARE:
        warnings.warn(
            f"{key}: the race had the processor for {share:.0%} of its time; other work runs "
            "on this machine and makes times too long, and nothing is judged",
            RuntimeWarning,
            stacklevel=2,
        )
    return racers, share
