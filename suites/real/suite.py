"""The suite `real`: which tasks, and who runs them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from recordings.thinning import frames_per_kept
from suites.real.dpoint_run import (
    CAMERA_RATES_HZ,
    FOLDER,
    NO_CAMERA,
    RATES,
    UNBIASED,
    WITH_CAMERA,
    WITHOUT_CAMERA,
    run_dpoint,
)
from suites.real.figures import figures

NAME = "real"
ALL = "accel+gyro+camera"
FEWER = ("ekf", "mhe-rti")
"""The estimators of every configuration but `ALL`, `mhe` costs three seconds a run."""


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks; a seed is a phase of the camera's thinning, of which there are few."""
    if missing(scope):
        return []
    recorded = max(CAMERA_RATES_HZ)
    found = [
        Task(NAME, case, sensors, estimator, phase)
        for estimator in reversed(BENCHMARK_ESTIMATORS)
        for sensors in WITH_CAMERA
        if sensors == ALL or estimator in FEWER
        for case, rate in RATES.items()
        for phase in range(min(scope.seeds, frames_per_kept(recorded, rate)))
    ]
    return found + [
        Task(NAME, case, sensors, estimator, 0)
        for case in (NO_CAMERA, UNBIASED)
        for sensors in WITHOUT_CAMERA
        if case == NO_CAMERA or "accel" in WITHOUT_CAMERA[sensors]
        for estimator in BENCHMARK_ESTIMATORS
    ]


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task."""
    assert scope.data is not None
    return run_dpoint(task, scope.data)


def missing(scope: Scope) -> str:
    """Return a line that says what is missing, where something is."""
    if scope.data is None:
        return (
            "suite real: left out, it needs recordings (--data FOLDER, or the variable "
            "PEN_MHE_DATA)"
        )
    if not (Path(scope.data) / FOLDER).is_dir():
        return f"suite real: left out, {scope.data} has no folder {FOLDER}"
    return ""


SUITE = Suite(
    name=NAME,
    title="A real pen",
    summary=(
        "The D-POINT stylus (Jcparkyn, MIT licence) wrote for 39 s with an accelerometer and a "
        "gyroscope in its barrel, followed by a camera at 30 Hz; the ink was scanned. Its frames "
        "are thinned to lower rates, a seed being a phase of the thinning. Zero delay: a frame is "
        "used at the moment of its capture, although this camera's frames arrive about 45 ms "
        "later, so the figures do not compare with causal ones. Ink: mean distance between the "
        "tip's path and the scanned ink after the best shift. Left out: RMS error against the "
        "frames that the estimator was not given. The array of eight IMUs stands in the suite "
        "gyro-free."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    missing=missing,
    reads=lambda task: FOLDER,
)
