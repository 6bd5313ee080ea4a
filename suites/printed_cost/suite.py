"""The suite ``printed-cost``: speeds are its cases, models stand where estimators do."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from models.names import unknown
from suites.printed_cost.figures import figures
from suites.printed_cost.run import (
    CASES,
    CONFIGURATIONS,
    DURATION_S,
    MODELS,
    MOTION,
    SETTLING_S,
    SPEEDS,
    CostCase,
    run_cost,
)
from suites.printed_cost.tables import tables

NAME = "printed-cost"


def tasks(scope: Scope) -> Sequence[Task]:
    """Return every model at every speed with every configuration."""
    return [
        Task(NAME, case, sensors, model, seed)
        for case in CASES
        for sensors in CONFIGURATIONS
        for model in MODELS
        for seed in range(scope.seeds)
    ]


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task."""
    if task.case not in CASES:
        raise unknown("case", task.case, CASES)
    return run_cost(CostCase(CASES[task.case], task.sensors, task.estimator), task.seed)


SUITE = Suite(
    name=NAME,
    title="What the paper's printed equations cost",
    summary=(
        f"The rigid body is simulated along ‘{MOTION}’, played {SPEEDS[0]:g} to {SPEEDS[-1]:g} "
        f"times as fast, for {DURATION_S:g} s. An EKF estimates it with the rigid body, with one "
        "of the errors that are printed in [Pen] (E2: the inverse matrix in (5); E3: the sign of "
        "x in (6); E4: no Coriolis term in (6)) and with all of them. Pen, motion, noise and what "
        "the EKF is told of them are the same for all: state (1) and readings (9), so no bias and "
        "no third rate, with sensors of today. A model stands where other suites have an "
        "estimator. “accelerometer error” is what its accelerometer says beyond the rigid "
        "body's, along the truth; “accelerometer noise” the standard deviation of one axis. "
        f"Errors of estimates leave out the first {SETTLING_S:g} s."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    tables=tables,
)
