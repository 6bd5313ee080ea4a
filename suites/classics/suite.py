"""The suite ``classics``: problems of the field on every estimator, nothing set but N."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.from_mhe import REFERENCE
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from suites.classics.figures import figures
from suites.classics.problems import PROBLEMS
from suites.classics.recordings import SENSOR
from suites.classics.run import run_problem

NAME = "classics"
ESTIMATORS = (REFERENCE, *reversed(BENCHMARK_ESTIMATORS))
"""The slow ones first."""
ALL_FROM = 100
"""From so many seeds on the slow one runs on all of them, below on a quarter."""


def _seeds(estimator: str, scope: Scope) -> int:
    is_cut = estimator == REFERENCE and scope.seeds < ALL_FROM
    return scope.few_seeds if is_cut else scope.seeds


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks, those of the slowest estimator first."""
    return [
        Task(NAME, case, SENSOR, estimator, seed)
        for estimator in ESTIMATORS
        for case in PROBLEMS
        for seed in range(_seeds(estimator, scope))
    ]


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task."""
    return run_problem(task)


SUITE = Suite(
    name=NAME,
    title="Classics: the field's own problems",
    summary=(
        "Problems on which others judge moving-horizon estimation, with their figures: two "
        "reactions of Haseltine and Rawlings (2005), whose priors are wrong by many deviations; "
        "an oscillator of van der Pol whose damping is estimated; do-mpc's rotating masses, one "
        "inertia of which is estimated; acados' pendulum on a cart, whose rod's length is (the "
        "true one does not change, the estimators reckon that it may); CasADi's damped spring, on "
        "which every estimator has to be the Kalman filter; a tank that is read through a "
        "root and nearly empty. All contenders read one file and the same samples; nothing is set "
        "but the horizon N. Truth is drawn with the model's noise; the tank's turns back at its "
        "bound, a disc that turns faster than its own is drawn anew. Bounds are obeyed by the moving-horizon estimators; Kalman filters have none. "
        "“samples within 3 deviations” is the fraction of the judged samples whose error is at "
        "most three claimed deviations; “run within 3 deviations” is 1 for a run in which the "
        "RMS of that ratio is; “success” is 1 for a run whose RMS error is small enough (of the "
        "spring: that is nowhere farther than 1e-9 from the Kalman filter), else 0. "
        "mhe-ipopt runs on a quarter of the seeds (on all of them from 100 on)."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
)
