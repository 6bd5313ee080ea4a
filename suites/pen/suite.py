"""The suite `pen`: which tasks, and who runs them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmark.configurations import TURNTABLE_CONFIGURATIONS
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from suites.pen.figures import figures
from suites.pen.pen_cases import PEN_CASES, PEN_ESTIMATORS
from suites.pen.pen_run import run_pen
from suites.pen.table_run import STARTS, STROKES, TABLE_ESTIMATORS, run_stroke, run_wrong_start

NAME = "pen"


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks, the pen's first: they take longest."""
    rows = [
        (case, sensors, estimator)
        for case, row in PEN_CASES.items()
        for sensors in row.sensors
        for estimator in PEN_ESTIMATORS
    ]
    rows += [
        (case, sensors, estimator)
        for case in (*STROKES, *STARTS)
        for sensors in TURNTABLE_CONFIGURATIONS
        for estimator in TABLE_ESTIMATORS
    ]
    # All seeds of a row after each other: its estimator is built once.
    return [Task(NAME, *row, seed) for row in rows for seed in range(scope.seeds)]


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task."""
    if task.case in PEN_CASES:
        return run_pen(task)
    if task.case in STARTS:
        return run_wrong_start(task)
    return run_stroke(task)


SUITE = Suite(
    name=NAME,
    title="Attitude of a pen: the turntable of [Pen], and the whole pen",
    summary=(
        "[Pen] (Cao, Liu, Liu, 2008) puts an accelerometer and a gyroscope on a turntable, writes "
        "strokes with it and compares three choices of sensors with an extended Kalman filter. "
        "Here its experiment is simulated, with its sensors' noise and its table's rates and "
        "tolerances; the strokes' corners and durations are ours. Every choice of sensors runs on "
        "every estimator, from starts that are right and from starts up to 60 deg wrong; runs that "
        "end in the mirror solution are counted apart. Then the same question is asked of the "
        "whole pen at the speed of handwriting, where the accelerations that the paper neglects "
        "are as large as what it measures."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
)
