"""The suite ``bad-starts``: who finds the truth from a wrong start, and how soon."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmark.configurations import BENCHMARK_ESTIMATORS, CONFIGURATIONS
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from pen_mhe.estimators import ESTIMATORS
from suites.bad_starts.cases import CASES, case_model, case_named
from suites.bad_starts.figures import figures
from suites.bad_starts.quantities import quantities, series
from suites.bad_starts.run import run_bad_start
from suites.bad_starts.tables import tables

NAME = "bad-starts"
UNSCENTED, UNSCENTED_CASES = "ukf", ("writing-60", "held-60")
"""It is slow: unless it is asked for, it runs from these starts only."""


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks, those of the slowest estimator first."""
    return [
        Task(NAME, case, sensors_of(case), estimator, seed)
        for estimator in reversed(list(ESTIMATORS))
        for case in _cases(estimator, scope)
        for seed in range(scope.seeds)
    ]


def _cases(estimator: str, scope: Scope) -> Sequence[str]:
    """Return the cases of an estimator: where some are asked for, of all that there are."""
    if scope.estimators is not None or estimator in BENCHMARK_ESTIMATORS:
        return list(CASES)
    return UNSCENTED_CASES if estimator == UNSCENTED else ()


def sensors_of(case: str) -> str:
    """Return the name of a case's choice of sensors."""
    sensors = CASES[case].sensors
    return next(name for name, row in CONFIGURATIONS.items() if row.sensors == sensors)


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task; raises `InputError` for an unknown case or estimator."""
    case = case_named(task.case)
    found = run_bad_start(case, task.estimator, task.seed)
    return Outcome(
        case_model(case).name,
        tuple(quantities(found)),
        len(found.time_s),
        found.solved_fraction,
        float(np.median(found.step_time_s)),
        float(np.quantile(found.step_time_s, 0.99)),
        series=series(found),
    )


SUITE = Suite(
    name=NAME,
    title="Bad starts: does optimisation pay where the start is wrong?",
    summary=(
        "Every estimator is started with an attitude that is wrong by a known turn about a drawn "
        "axis (a pen that does not spin: with a wrong elevation), and told so honestly. Gravity "
        "then shows the truth, but not linearly. Judged is the direction of up as the body sees "
        "it, for the heading is seen by nothing but a camera; its error is the angle between true "
        "and estimated up, its claimed deviation that in the error's own direction. What else is "
        "told decides the outcome more than the start does: a hand that may accelerate the tip, "
        "or a bias, can hide a tilt for good. ukf runs from two of the starts, unless "
        "--estimators names it."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    tables=tables,
)
