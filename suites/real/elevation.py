"""Elevation without a camera, judged by the camera that took no part.

Nothing then sees the paper: the estimator's frame is gravity's, and so is that in which the
camera's elevation is told, by the `level_deg` of the pen file.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmark.tasks.task import Quantity, Series
from estimation.estimate import EstimateHistory
from estimation.recording import Recording
from models.arrays import Array
from models.level import up_direction
from models.pen_config import PenConfig

SETTLING_S = 5.0
"""Begin that the elevation's spread leaves out: without a camera, its level is learnt first."""

DEG = 180 / math.pi


def elevation_quantities(
    pen: PenConfig, history: EstimateHistory, recording: Recording
) -> list[Quantity]:
    """Return how far the elevation is from the camera's, and how much that changes.

    The spread, a standard deviation, leaves out what the paper's level and the camera's mounting
    may be off by.

    Parameters
    ----------
    pen : of the recording, with its camera and its paper's level
    """
    times, elevation = camera_elevation(pen, recording)
    estimated = np.interp(times, history.time_s, history.column("elevation_rad"))
    later = (times >= times[0] + SETTLING_S) & (times <= history.time_s[-1])
    errors = DEG * (estimated - elevation)[later]
    return [
        Quantity.of_errors("elevation", "deg", errors),
        Quantity.single("elevation_spread", "deg", float(np.std(errors))),
    ]


def elevation_series(
    pen: PenConfig, history: EstimateHistory, recording: Recording
) -> tuple[Series, ...]:
    """Return the elevation over time, and the camera's as the truth."""
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


def camera_elevation(pen: PenConfig, recording: Recording) -> tuple[Array, Array]:
    """Return times (n,) and elevations over the horizon (n,), rad, of the axis as it is seen."""
    cameras: list[Any] = [sensor for sensor in pen.sensors.values() if sensor.sees_pose]
    times, poses = recording.sensor("camera")
    axis_in_sensor = np.array(cameras[0].sensor_to_body).T @ [0.0, 0.0, 1.0]
    axis = Rotation.from_rotvec(poses[:, 3:]).apply(axis_in_sensor)
    return times, np.arcsin(np.clip(axis @ up_direction(pen.level_rad), -1, 1))
