"""A run on the D-POINT recording: some sensors, a camera thinned to some rate, one phase."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmark.tasks.history import outcome
from benchmark.tasks.task import Outcome, Quantity, Series, Task
from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run
from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from pen_mhe.estimators import create_estimator
from recordings.formats.dpoint import load_dpoint
from recordings.ink import ink_match
from recordings.thinning import CameraThinning, left_out_error, thinned
from recordings.written import WrittenRecording

PEN, FOLDER = "dpoint", "dpoint_pen"
CAMERA_RATES_HZ = (30, 15, 10, 6, 5, 3)
"""Each divides the recorded rate."""

RATES: Mapping[str, int] = MappingProxyType({f"camera at {r} Hz": r for r in CAMERA_RATES_HZ})
"""Case → camera rate."""

NO_CAMERA, UNBIASED = "no camera", "no camera, accelerometer taken as unbiased"
WITH_CAMERA: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "camera": ("camera",),
        "accel+camera": ("accel", "camera"),
        "gyro+camera": ("gyro", "camera"),
        "accel+gyro+camera": ("accel", "gyro", "camera"),
        "accel+gyro+camera+contact": ("accel", "gyro", "camera", "contact"),
    }
)
WITHOUT_CAMERA: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"accel": ("accel",), "gyro": ("gyro",), "accel+gyro": ("accel", "gyro")}
)
"""Configuration → sensors of the pen file."""

CLOCK = "accel"
"""The sensor at whose instants the tip's path is judged."""

SETTLING_S = 5.0
"""Begin that the elevation's spread leaves out: without a camera, its level is learnt first."""

DEG = 180 / math.pi
SHOWN_S = 8.0
"""Length of the series that a figure shows."""


def run_dpoint(task: Task, data: str) -> Outcome:
    """Run an estimator on the recording.

    Parameters
    ----------
    task : its seed is the phase of the thinning
    data : folder that holds `FOLDER`
    """
    written, pen = _recording(data), _pen(task.case)
    estimator = _estimator(task.case == UNBIASED, task.sensors, task.estimator)
    model = estimator.model
    sensors = {**WITH_CAMERA, **WITHOUT_CAMERA}[task.sensors]
    whole = written.recording
    if task.case in (NO_CAMERA, UNBIASED):
        history = run(estimator, whole.select(sensors))
        found = elevation_quantities(pen, history, whole)
        return outcome(model.name, history, found, series=_elevation(task, pen, history, whole))
    # The tip is wanted at the instants of the clock, whether or not that sensor is used.
    times, ticks = whole.sensor(CLOCK)
    instants = Recording.from_sensors(
        whole.name,
        {name: whole.sensor(name) for name in sensors} | {"clock": (times, np.zeros_like(ticks))},
    )
    used = thinned(model, instants, CameraThinning(RATES[task.case], task.seed))
    history = run(estimator, used)
    output = history.at(used.sensor("clock")[0])
    found = []
    if written.ink is not None and (match := ink_match(output, written.ink)) is not None:
        found.append(Quantity.single("ink", "mm", match.mean_distance_mm))
    camera = model.sensor("camera")
    if (left_out := left_out_error(model, camera, history, instants, used)) is not None:
        for quantity, unit, shown, factor in (
            ("left_out_position", "m", "mm", 1e3),
            ("left_out_orientation", "rad", "deg", DEG),
        ):
            found.append(Quantity.single(quantity, shown, factor * left_out.rms[unit]))
    series = _paths(task, output) if task.seed == 0 else ()
    return outcome(model.name, history, found, series=series)


def elevation_quantities(
    pen: PenConfig, history: EstimateHistory, recording: Recording
) -> list[Quantity]:
    """Return how far the elevation is from the camera's, and how much that changes.

    The camera takes no part in the estimate. Its mounting and the paper's level are known
    to some tenths of a degree only: the spread, a standard deviation, leaves that out.
    """
    times, elevation = camera_elevation(pen, recording)
    estimated = np.interp(times, history.time_s, history.column("elevation_rad"))
    later = (times >= times[0] + SETTLING_S) & (times <= history.time_s[-1])
    errors = DEG * (estimated - elevation)[later]
    return [
        Quantity.of_errors("elevation", "deg", errors),
        Quantity.single("elevation_spread", "deg", float(np.std(errors))),
    ]


def camera_elevation(pen: PenConfig, recording: Recording) -> tuple[Array, Array]:
    """Return times (n,) and elevations (n,), rad, of the pen's axis as the camera sees it."""
    cameras: list[Any] = [sensor for sensor in pen.sensors.values() if sensor.sees_pose]
    times, poses = recording.sensor("camera")
    axis_in_sensor = np.array(cameras[0].sensor_to_body).T @ [0.0, 0.0, 1.0]
    axis = Rotation.from_rotvec(poses[:, 3:]).apply(axis_in_sensor)
    return times, np.arcsin(np.clip(axis[:, 2], -1, 1))


def _elevation(
    task: Task, pen: PenConfig, history: EstimateHistory, recording: Recording
) -> tuple[Series, ...]:
    times, elevation = camera_elevation(pen, recording)
    kept = (history.time_s >= times[0]) & (history.time_s <= times[-1])
    at = history.time_s[kept]
    return (
        Series(
            "elevation",
            "deg",
            at,
            DEG * history.column("elevation_rad")[kept],
            DEG * history.std_of("elevation_rad")[kept],
            DEG * np.interp(at, times, elevation),
        ),
    )


def _paths(task: Task, output: EstimateHistory) -> tuple[Series, ...]:
    shown = output.time_s <= output.time_s[0] + SHOWN_S
    return tuple(
        Series(
            f"tip_{axis}", "mm", output.time_s[shown], 1e3 * output.column(f"tip_{axis}_m")[shown]
        )
        for axis in "xy"
    )


@cache
def _recording(data: str) -> WrittenRecording:
    folder = Path(data) / FOLDER
    if not folder.is_dir():
        raise InputError(f"data folder {data} has no {FOLDER}, expected it there")
    return load_dpoint(folder, load_pen(PEN))


@cache
def _estimator(unbiased: bool, sensors: str, name: str) -> Estimator[Any]:
    chosen = {**WITH_CAMERA, **WITHOUT_CAMERA}[sensors]
    return create_estimator(name, pen_model(_pen(UNBIASED if unbiased else NO_CAMERA), chosen))


@cache
def _pen(case: str) -> PenConfig:
    """Return the pen that an estimator assumes.

    Without a camera, a bias of the accelerometer and a tilt of the pen are nearly the same
    to every reading; `UNBIASED` tells the estimator that there is none.
    """
    pen = load_pen(PEN)
    if case != UNBIASED:
        return pen
    accelerometer = pen.sensors["accel"].model_copy(
        update={"bias_std_m_s2": 0.0, "bias_walk_m_s2_per_sqrt_s": 0.0}
    )
    return pen.model_copy(
        update={"sensors": MappingProxyType({**pen.sensors, "accel": accelerometer})}
    )
