"""The suite ``consistency``: are errors as large as is claimed?"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.tasks.history import outcome
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Series, Task
from models.pen_file import load_pen
from pen_mhe.estimators import ESTIMATORS
from suites.consistency.figures import figures, tables
from suites.consistency.pens import PEN, choices, made_of, own, pen_of
from suites.consistency.quantities import NEES, quantities
from suites.consistency.run import CASES, SETTLED_S, ConsistencyBench, bench, case_named

NAME = "consistency"


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks, those of the slowest estimator first."""
    asked = BENCHMARK_ESTIMATORS if scope.estimators is None else ESTIMATORS
    return [
        Task(NAME, case, "+".join(sensors), estimator, seed)
        for estimator in reversed(list(asked))
        for sensors in choices(pen_of(scope))
        for case in CASES
        for seed in range(scope.seeds)
    ]


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task; raises `InputError` for an unknown case, sensor or estimator."""
    built = _bench(scope.pen or PEN, task.sensors, task.case, task.estimator)
    found = history, of_run, _ = built.run(task.seed)
    over_time = Series(NEES, "1", history.time_s, of_run / built.model.n_x)
    said = quantities(built.statistics([found]))
    return outcome(built.model.name, history, said, series=(over_time,))


@lru_cache(maxsize=16)
def _bench(pen: str, sensors: str, case: str, estimator: str) -> ConsistencyBench:
    return bench(load_pen(pen), tuple(sensors.split("+")), case_named(case), estimator)


SUITE = Suite(
    name=NAME,
    title="Consistency: can one trust the standard deviations?",
    summary=(
        "Truth is drawn anew for every seed, from the model itself: there a consistent estimator "
        "has a mean NEES (squared error, measured by its own covariance) of the number of states "
        "and a mean NIS per row of 1; the error of a single state over its deviation has an RMS "
        "of 1, which may be so where the states together are not consistent. The standard error "
        "is taken across runs, because the instants of one run are not independent. The first "
        f"sample is counted apart, and the NEES from {SETTLED_S:g} s on: an update that is "
        "linearised where the prior has the pen at rest knows nothing of ω²r. Smooth handwriting "
        "is no white jerk: what its rows show is what the process noise is worth, not whether an "
        "estimator is right. The pen is D-POINT's with all its sensors that read motion, and with "
        "these but the camera; --pen asks another."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    tables=tables,
    own=own,
    made_of=made_of,
)
