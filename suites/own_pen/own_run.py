"""A run of one's own pen, simulated or recorded."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmark.tasks.history import outcome
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Quantity, Task
from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run
from estimation.outputs import outputs_of
from estimation.recording import Recording
from models.errors import InputError
from models.pen import pen_model
from models.pen_file import load_pen
from models.regular_files import open_regular
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from pen_mhe.sensor_verdict import judge
from pen_mhe.tuning.gaps import camera_elevation
from recordings.read import read_recording
from recordings.simulate_pen import sensors_with_a_rate, simulate
from suites.pen_quantities import SETTLING_S, pen_quantities

DURATION_S = 4.0
"""Of a simulated recording."""

DEG = 180 / math.pi


def run_own(task: Task, scope: Scope) -> Outcome:
    """Run an estimator on a choice of the pen's sensors: their names with ``+``."""
    assert scope.pen is not None
    chosen = tuple(task.sensors.split("+"))
    estimator = _estimator(scope.pen, chosen, task.estimator)
    model, whole = estimator.model, recording_of(scope, task.seed)
    measured = [sensor.name for sensor in model.measured_sensors]
    history = run(estimator, replace(whole.select(measured), truth=None))
    if whole.truth is not None:
        quantities = pen_quantities(model, history, whole.truth, _seen(scope, chosen))
    else:
        quantities = _by_camera(scope, chosen, history, whole)
    return outcome(model.name, history, quantities)


def camera_of(scope: Scope, recording: Recording) -> str | None:
    """Return the pen's camera that a recording has readings of; None without one."""
    assert scope.pen is not None
    sensors = load_pen(scope.pen).sensors
    return next((n for n in sensors if sensors[n].sees_pose and n in recording.readings), None)


def recording_of(scope: Scope, seed: int) -> Recording:
    """Return the recording of a seed; a real one is the same for all."""
    assert scope.pen is not None
    if scope.recording is not None:
        return _read(scope.recording, scope.pen)
    pen = load_pen(scope.pen)
    return simulate(pen, None, motion=scope.motion, duration_s=DURATION_S, seed=seed)


def made_of(scope: Scope) -> str:
    """Return a hash of the pen as it is read, the motion, and the files of the recording.

    Raises
    ------
    InputError
        If one of them cannot be read.
    """
    assert scope.pen is not None
    digest = hashlib.sha256(load_pen(scope.pen).model_dump_json().encode())
    digest.update(scope.motion.encode())
    if scope.recording is not None:
        path = Path(scope.recording)
        files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
        for file in files:
            with open_regular(file, f"recording {file}", "a readable file", "table_bytes") as data:
                digest.update(file.name.encode() + data.read())
    return digest.hexdigest()[:16]


def _by_camera(
    scope: Scope, chosen: tuple[str, ...], history: EstimateHistory, recording: Recording
) -> list[Quantity]:
    """Return the distance of the elevation from the camera's, where the choice does not use it."""
    camera = camera_of(scope, recording)
    if camera is None or camera in chosen:
        return []
    assert scope.pen is not None
    sensor: Any = load_pen(scope.pen).sensors[camera]
    times, poses = recording.sensor(camera)
    elevation = camera_elevation(poses, np.array(sensor.sensor_to_body))
    start = max(times[0], history.time_s[0]) + SETTLING_S
    kept = (times >= start) & (times <= history.time_s[-1])
    at, true = times[kept], elevation[kept]
    estimated, std = (
        np.interp(at, history.time_s, of)
        for of in (history.column("elevation_rad"), history.std_of("elevation_rad"))
    )
    seen = _seen(scope, chosen)["elevation_rad"]
    errors = DEG * (estimated - true)
    return [Quantity.of_errors("elevation", "deg", errors, seen, claimed=DEG * std)]


@cache
def _read(path: str, pen: str) -> Recording:
    return read_recording(path, load_pen(pen))


@cache
def _estimator(pen: str, chosen: tuple[str, ...], name: str) -> Estimator[Any]:
    return create_estimator(name, _model(pen, chosen))


@cache
def _model(pen: str, chosen: tuple[str, ...]) -> StateSpaceModel:
    """Return the model that estimators of a choice share, with what is derived of it."""
    return pen_model(load_pen(pen), chosen)


@cache
def _seen(scope: Scope, chosen: tuple[str, ...]) -> Mapping[str, bool]:
    """Return which outputs a choice shows along the simulated motion.

    A sensor without a rate cannot be simulated: what it adds (a contact) is left out.
    """
    assert scope.pen is not None
    pen = load_pen(scope.pen)
    rated = [name for name in chosen if name in sensors_with_a_rate(pen)]
    if not rated:
        raise InputError(
            f"sensors {', '.join(chosen)} of pen {pen.name} have no rate, expected rate_hz"
        )
    model = pen_model(pen, rated)
    whole = simulate(pen, rated, motion=scope.motion, duration_s=DURATION_S, seed=0)
    found = judge(model, whole)
    return MappingProxyType({name: found.sees(name) for name in outputs_of(model).names})
