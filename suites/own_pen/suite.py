"""The suite ``own-pen``: the same matrix and advice, of a pen of one's own."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmark.configurations import BENCHMARK_ESTIMATORS, SensorConfiguration
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Task
from models.errors import InputError
from models.names import unknown
from models.pen_file import load_pen
from recordings.motion_list import motion_names
from recordings.simulate_pen import sensors_with_a_rate
from suites.own_pen.choices import choices
from suites.own_pen.own_run import camera_of, made_of, recording_of, run_own

NAME = "own-pen"


def tasks(scope: Scope) -> list[Task]:
    """Return every choice of sensors with every estimator; a recording is run once.

    Raises
    ------
    InputError
        If pen, motion or recording are not there, or a recording has nothing to be judged by.
    """
    seeds = scope.seeds if scope.recording is None else 1
    return [
        Task(NAME, _case(scope), row.label, estimator, seed)
        for row in _configurations(scope)
        for estimator in reversed(BENCHMARK_ESTIMATORS)
        for seed in range(seeds)
    ]


def own(scope: Scope) -> Mapping[str, Any]:
    """Return what the report says of the pen, and the command that asks again."""
    assert scope.pen is not None
    words = ["pen-mhe", "benchmark", "pen", "--pen", scope.pen]
    if scope.recording is None:
        words += ["--motion", scope.motion, "--seeds", str(scope.seeds)]
    else:
        words += ["--recording", Path(scope.recording).name]
    if scope.estimators is not None:
        words += ["--estimators", ",".join(scope.estimators)]
    return {
        "configurations": [asdict(row) for row in _configurations(scope)],
        "answer_is_about": f"Pen {load_pen(scope.pen).name}, {_scored(scope)}.",
        "again": shlex.join(words),
    }


def _case(scope: Scope) -> str:
    return scope.motion if scope.recording is None else Path(scope.recording).name


def _configurations(scope: Scope) -> Sequence[SensorConfiguration]:
    assert scope.pen is not None
    pen = load_pen(scope.pen)
    if scope.recording is None:
        if scope.motion not in motion_names():
            raise unknown("motion", scope.motion, motion_names())
        return choices(pen, sensors_with_a_rate(pen))
    recording = recording_of(scope, 0)
    if recording.truth is None and camera_of(scope, recording) is None:
        raise InputError(
            f"recording {scope.recording} has neither a truth nor readings of a camera of pen "
            f"{pen.name}, expected one of them to judge estimates by"
        )
    return choices(pen, recording.readings)


def _scored(scope: Scope) -> str:
    if scope.recording is None:
        return f"simulated along {scope.motion}, judged by the true motion"
    if recording_of(scope, 0).truth is not None:
        return f"recorded in {_case(scope)}, judged by the truth in that file"
    return (
        f"recorded in {_case(scope)}. Judged is the elevation without a camera, by the camera, "
        "whose mounting counts as exact; choices with the camera have no figure"
    )


SUITE = Suite(
    name=NAME,
    title="A pen of one's own",
    summary=(
        "Which of its sensors does this pen need, and which estimator? Every choice of its sensors "
        "that observes something, on every estimator; of several sensors of one kind the first, "
        "the first two and so on; what only adds to others, a contact, beside all the others. What "
        "is told of the hand is what the pen file states. The first second of a run is not judged. "
        "Whether sensors show a quantity is decided along a simulated motion."
    ),
    tasks=tasks,
    run=run_own,
    claims=None,
    figures=lambda results: [],
    own=own,
    made_of=made_of,
)
