"""What is known of a race: one row per contender, mode and problem."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from suites.speed.clock import THREAD_CLOCK
from suites.speed.contender import RaceOutcome
from suites.speed.problems import Problem
from suites.speed.runner import Racer


@dataclass(frozen=True)
class Row:
    """One contender on one problem; times in seconds, None where there is nothing.

    Parameters
    ----------
    problem, bounds : name, and whether it is the one with bounds
    contender, mode, version : who, doing what
    horizon : N of the window; 0 for a filter
    windows : windows, samples or whole streams that were timed
    median_s, p99_s, max_s : wall time per window or sample
    cost : mean over the windows of the true window cost at the contender's solution
    build_s : time to build the contender, compilation included
    newest_error_std, newest_error_max_std : median and largest distance of the newest state
        from the reference's, in its standard deviations (largest component)
    solved : fraction of the windows that the contender calls solved
    active_rows : bounds that are active in a window of the reference, mean; None without bounds
    violation_std : by how much a bound is exceeded at most in any window, in standard
        deviations; None without bounds
    min_s : the least wall time of all repeats
    cpu_min_s, cpu_median_s : of CPU time, the least of all repeats and the median over windows
    clock : who told the CPU time: one of those of `suites.speed.clock`
    core_share : part of the race in which a core was this process's
    """

    problem: str
    bounds: bool
    contender: str
    mode: str
    horizon: int
    windows: int
    median_s: float
    p99_s: float
    max_s: float
    cost: float | None
    build_s: float
    version: str
    newest_error_std: float | None
    newest_error_max_std: float | None
    solved: float
    active_rows: float | None = None
    violation_std: float | None = None
    min_s: float = field(kw_only=True)
    cpu_min_s: float = field(kw_only=True)
    cpu_median_s: float = field(kw_only=True)
    clock: str = THREAD_CLOCK
    core_share: float = 1.0


@dataclass(frozen=True)
class Quality:
    """What a solution of a window is worth: its cost, and by how much it exceeds a bound."""

    cost: float
    violation_std: float = 0.0


def row(
    racer: Racer[Any],
    problem: Problem,
    model: StateSpaceModel,
    references: Sequence[GaussianState],
    quality: Callable[[int, RaceOutcome], Quality] | None = None,
    active_rows: float | None = None,
    *,
    core_share: float = 1.0,
) -> Row:
    """Return the row of a contender after its race.

    Parameters
    ----------
    references : per timed item, the newest state as it should be, and its covariance
    quality : number of the timed item and outcome → true quality of it
    active_rows : of the problem's windows, mean; None for a problem without bounds
    core_share : of the race
    """
    times, outcomes, entry = np.array(racer.times_s), racer.outcomes, racer.entry
    errors = [_away(model, o.newest, r) for o, r in zip(outcomes, references, strict=True)]
    found = [quality(i, outcome) for i, outcome in enumerate(outcomes)] if quality else []
    violations = [each.violation_std for each in found]
    return Row(
        problem=problem.name,
        bounds=problem.bounded,
        contender=entry.name,
        mode=entry.mode,
        horizon=problem.horizon if entry.horizon is None else entry.horizon,
        windows=len(times),
        median_s=float(np.median(times)),
        p99_s=float(np.quantile(times, 0.99)),
        max_s=float(times.max()),
        cost=_number(np.mean([each.cost for each in found])) if found else None,
        build_s=racer.build_s,
        version=racer.contender.version,
        newest_error_std=_number(np.median(errors)) if entry.judged else None,
        newest_error_max_std=_number(np.max(errors)) if entry.judged else None,
        solved=float(np.mean([outcome.solved for outcome in outcomes])),
        active_rows=active_rows,
        violation_std=_number(np.max(violations)) if found and problem.bounded else None,
        min_s=min(float(turn.wall_s.min()) for turn in racer.turns),
        cpu_min_s=min(float(turn.cpu_s.min()) for turn in racer.turns),
        cpu_median_s=float(np.median([np.median(turn.cpu_s) for turn in racer.turns])),
        clock=racer.turns[0].readings[0].clock,
        core_share=core_share,
    )


def _away(model: StateSpaceModel, newest: Array, reference: GaussianState) -> float:
    """Return the largest distance of a state's components, in standard deviations."""
    away = model.difference(newest, reference.mean).full().ravel()
    return float(np.abs(away / reference.std).max())


def _number(value: Any) -> float | None:
    """Return the value, None where it is not finite."""
    return float(value) if math.isfinite(value) else None
