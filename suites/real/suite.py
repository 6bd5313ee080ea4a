"""The suite `real`: which tasks, and who runs them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from recordings.thinning import frames_per_kept
from suites.real.cases import (
    AWAY,
    BEST,
    CAMERA_ALONE,
    CAMERA_RATES_HZ,
    CASES,
    CAUSAL,
    INERTIAL,
    NO_CAMERA,
    UNBIASED,
    WITH_CAMERA,
    WITHOUT,
    WITHOUT_CAMERA,
    WITHOUT_RATES_HZ,
    ZERO_DELAY,
)
from suites.real.dpoint_run import FOLDER, run_dpoint, variant
from suites.real.figures import figures

NAME = "real"
FAST, SLOW = ("ekf", "mhe-rti"), "mhe"
"""``mhe`` takes two seconds a run: on `BEST`, at some rates, and few phases."""

LOOKS_BACK = "mhe-rti"
"""The estimator that is also asked what it knows some samples later."""


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks; a seed is a phase of the camera's thinning, of which there are few."""
    if missing(scope):
        return []
    rows = [(f"causal, {rate} Hz", BEST, SLOW, scope.few_seeds) for rate in WITHOUT_RATES_HZ]
    for estimator in reversed(FAST):
        rows += [
            (case, sensors, estimator, scope.seeds if whole else scope.few_seeds)
            for case in CAUSAL
            for sensors in WITH_CAMERA
            for whole in [estimator != LOOKS_BACK or sensors == BEST]
            if sensors != CAMERA_ALONE  # no estimate between frames
        ]
        rows += [
            (case, sensors, estimator, scope.few_seeds)
            for case in ZERO_DELAY
            for sensors in (CAMERA_ALONE, INERTIAL, BEST)
            if estimator != LOOKS_BACK or sensors == BEST
        ]
        rows += [(case, BEST, estimator, scope.few_seeds) for case in WITHOUT]
        rows += [(AWAY, BEST, estimator, scope.seeds)]
    found = [
        Task(NAME, case, sensors, estimator, seed)
        for case, sensors, estimator, seeds in rows
        for seed in range(min(seeds, _seeds_of(case)))
    ]
    return found + [
        Task(NAME, case, sensors, estimator, 0)
        for case in (NO_CAMERA, UNBIASED)
        for sensors in WITHOUT_CAMERA
        if case == NO_CAMERA or "accel" in WITHOUT_CAMERA[sensors]
        for estimator in (*FAST, *((SLOW,) if sensors == "accel+gyro" else ()))
    ]


def _seeds_of(case: str) -> int:
    """Return how many seeds a case has: phases, but for a camera that looks away."""
    most = max(CAMERA_RATES_HZ)
    return most if CASES[case].away_s else frames_per_kept(most, CASES[case].rate_hz)


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task."""
    assert scope.data is not None
    is_asked = task.case in CAUSAL and task.sensors == BEST and task.estimator == LOOKS_BACK
    return run_dpoint(task, scope.data, looks_back=is_asked)


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
        "are thinned to lower rates, a seed being a phase of the thinning. Causal: an estimate at "
        "an instant of the accelerometer uses what had arrived by then, and a frame arrives 45 ms "
        "after its capture. Looking back: the same run tells of an instant again when 14 more "
        "samples of the accelerometer have arrived (N = 26). Zero delay: a frame is used at its "
        "capture already, as nobody can. Ink: mean distance between the tip's path and the "
        "scanned ink after the best shift. Left out: RMS error against the frames that the "
        "estimator was not given. Without: one thing that the pen file knows is taken out of it. "
        "The array of eight IMUs stands in the suite gyro-free."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    missing=missing,
    reads=lambda task: FOLDER,
    row=lambda task: (variant(task.case), task.sensors),
)
