"""The suite `pen`: which tasks, and who runs them."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from pathlib import Path

from benchmark.configurations import TURNTABLE_CONFIGURATIONS
from benchmark.from_mhe import NEAR, REFERENCE
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from suites.pen.figures import figures
from suites.pen.known_start import KNOWN_STARTS, SENSORS, run_known_start
from suites.pen.pen_cases import PEN_CASES
from suites.pen.pen_run import run_pen
from suites.pen.table_run import (
    STARTS,
    STROKES,
    TABLE_ESTIMATORS,
    WITH_IPOPT,
    run_stroke,
    run_wrong_start,
)
from suites.pen.told_tolerance import SWEEP, SWEEP_ESTIMATORS

NAME = "pen"


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks, the pen's first: they take longest."""
    rows = [
        ((case, sensors, estimator), scope.few_seeds if row.has_few_seeds else scope.seeds)
        for case, row in PEN_CASES.items()
        for sensors in row.sensors
        for estimator in row.estimators
    ]
    rows += [
        ((case, SENSORS, estimator), scope.seeds)
        for case, start in KNOWN_STARTS.items()
        for estimator in start.estimators
    ]
    rows += [
        ((WITH_IPOPT, sensors, estimator), scope.few_seeds)
        for sensors in TURNTABLE_CONFIGURATIONS
        for estimator in (REFERENCE, NEAR)
    ]
    rows += [
        ((case, sensors, estimator), scope.seeds)
        for case in (*STROKES, *STARTS)
        for sensors in TURNTABLE_CONFIGURATIONS
        for estimator in TABLE_ESTIMATORS
    ]
    rows += [
        ((case, sensors, estimator), scope.seeds)
        for case in SWEEP
        for sensors in TURNTABLE_CONFIGURATIONS
        for estimator in SWEEP_ESTIMATORS
    ]
    return [Task(NAME, *row, seed) for row, seeds in rows for seed in range(seeds)]


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task."""
    if task.case in PEN_CASES:
        return run_pen(task)
    if task.case in KNOWN_STARTS:
        return run_known_start(task)
    if task.case in STARTS:
        return run_wrong_start(task)
    return run_stroke(task)


def row(task: Task) -> Hashable:
    """Return what tasks share: a pen's model and estimators, the turntable's recordings."""
    if task.case in PEN_CASES:
        return PEN_CASES[task.case].assumed, task.sensors
    if task.case in KNOWN_STARTS:
        return "known start", KNOWN_STARTS[task.case].pen
    return task.case


SUITE = Suite(
    name=NAME,
    title="Attitude of a pen: one that spins in the hand, and the world of [Pen]",
    summary=(
        "Which sensors does a pen need that spins in a writer's hand? Eight choices of data-sheet "
        "sensors, their biases estimated, run on every estimator along simulated handwriting; the "
        "estimators are told the hand that the pen file states, never the truth. [Pen] (Cao, Liu, "
        "Liu, 2008) asks the same of a pen that cannot spin: the same handwriting without spin "
        "stands beside, with what it costs to believe it of a pen that does, and with what the "
        "paper neglects, accelerations that are as large as what it measures. Its own experiment, "
        "an accelerometer and a gyroscope on a turntable that writes strokes, is simulated with "
        "its sensors' noise and its table's rates and tolerances; the strokes' corners and "
        "durations are ours. Starts there are right, or up to 60 deg wrong; runs that end in the "
        "mirror solution are counted apart."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    row=row,
)
