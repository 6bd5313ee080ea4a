"""The suite ``gyro-free``: [GyroFree], and the pen model with the same two accelerometers."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from pathlib import Path

from benchmark.from_mhe import NEAR, REFERENCE
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from models.errors import InputError
from models.names import unknown
from suites.gyro_free.array_pairs import FOLDER, PARTS
from suites.gyro_free.array_task import run_array
from suites.gyro_free.cases import (
    ARRAY_CASES,
    ARRAY_CLASSICAL,
    BEGIN,
    CASES,
    MODEL_BASED,
    SLOW_FIRST,
    TWO_ACCELS,
)
from suites.gyro_free.figures import figures
from suites.gyro_free.simulated import run_simulated

NAME = "gyro-free"
WITH_IPOPT = (REFERENCE, NEAR)
"""Estimators of the begin that IPOPT solves: 50 ms a step."""


def tasks(scope: Scope) -> list[Task]:
    """Return the tasks of the suite, those of the slowest estimator first."""
    found = simulated_tasks(scope.seeds)
    found += [
        Task(NAME, BEGIN, TWO_ACCELS, estimator, seed)
        for estimator in WITH_IPOPT
        for seed in range(scope.few_seeds)
    ]
    if has_array(scope):
        segments = {part: len(PARTS[part](str(scope.data))) for part in PARTS}
        found += array_tasks(scope.seeds, segments)
    order = {estimator: place for place, estimator in enumerate(SLOW_FIRST)}
    return sorted(found, key=lambda task: order.get(task.estimator, len(order)))


def simulated_tasks(seeds: int) -> list[Task]:
    """Return the tasks on simulated gestures: every seed is one gesture."""
    found = []
    for name, case in CASES.items():
        rows = [(TWO_ACCELS, estimator) for estimator in case.classical]
        rows += [(sensors, estimator) for sensors in case.sensors for estimator in MODEL_BASED]
        found += [Task(NAME, name, *row, seed) for row in rows for seed in range(seeds)]
    return found


def array_tasks(seeds: int, segments: Mapping[str, int]) -> list[Task]:
    """Return the tasks on the real array: every seed is one segment of a part, while it has any."""
    return [
        Task(NAME, name, TWO_ACCELS, estimator, seed)
        for name, case in ARRAY_CASES.items()
        for estimator in (*ARRAY_CLASSICAL, *(MODEL_BASED if case.model_based else ()))
        for seed in range(min(seeds, segments[case.part]))
    ]


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task.

    Raises
    ------
    InputError
        If its case is unknown, or has no data.
    """
    if task.case in ARRAY_CASES:
        if scope.data is None:
            raise InputError(f"case {task.case} has no data, expected a folder of recordings")
        return run_array(task, scope.data)
    if task.case not in CASES:
        raise unknown("case", task.case, (*CASES, *ARRAY_CASES))
    return run_simulated(task)


def row(task: Task) -> Hashable:
    """Return what tasks share: the gesture and the pens of a case, the pairs of an array."""
    return ARRAY_CASES[task.case].pairs if task.case in ARRAY_CASES else task.case


def has_array(scope: Scope) -> bool:
    """Return whether the recording of the array is there."""
    return scope.data is not None and (Path(scope.data) / FOLDER).is_dir()


def missing(scope: Scope) -> str:
    """Say that the recording is not there, where it is not."""
    if has_array(scope):
        return ""
    return f"No {FOLDER} among the data: two accelerometers on simulated gestures only."


SUITE = Suite(
    NAME,
    "Without gyroscopes [GyroFree]",
    "Two three-axis accelerometers on the long axis of a pen stand in for a gyroscope: their "
    "difference is integrated, and a redundant equation corrects the rate inside the "
    "integration. The test case has the paper's numbers (l = 0.04 m, 2 s, 5 ms, bias 1e-4 g and "
    "noise 1e-5 g of the difference); its profile is lost, and ours is a substitute: a gesture "
    "from rest whose rate turns its direction. Differentiator, thresholds and gain of the "
    "compensation are ours, too, and so is what it takes off: its settings stand beside each "
    "other. EKF and MHE get the same two accelerometers through the pen model, estimate their "
    "biases as well, and are free to roll, told that the pen does not roll (as the integration "
    "takes it), or that its spin is constant. Where data is given, pairs of accelerometers on a "
    "real board are judged by its gyroscopes.",
    tasks,
    run,
    Path(__file__).parent / "claims.toml",
    figures,
    missing,
    row=row,
)
