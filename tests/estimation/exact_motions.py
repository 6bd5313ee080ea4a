"""Pens in motions that obey their model exactly, read without noise."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from estimation.observability import Observability, observability
from estimation.recording import Measurement
from models.arrays import Array
from models.motion import white_jerk_motion
from models.pen import pen_model
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_kinds.writing_area import WritingArea
from models.state_space import StateSpaceModel
from tests.models.pens import ACCELEROMETER, CAMERA, GYROSCOPE, call, pen

CENTRE = (0.05, 0.02, 0.0)
"""Of the writing area: beside the tip."""
ACCEL_AT, LOWER_AT, UPPER_AT = (0.0, 0.0, 0.1), (0.0, 0.0, 0.03), (0.0, 0.0, 0.13)
SENSORS: dict[str, Any] = {
    "accel": Accelerometer(**ACCELEROMETER, position_m=ACCEL_AT),
    "gyro": Gyroscope(**GYROSCOPE, position_m=ACCEL_AT),
    "lower": Accelerometer(**ACCELEROMETER, position_m=LOWER_AT),
    "upper": Accelerometer(**ACCELEROMETER, position_m=UPPER_AT),
    "camera": PoseCamera(**CAMERA, position_m=(0.0, 0.0, 0.14)),
    "area": WritingArea(centre_m=CENTRE),
}
INERTIAL = {
    "accel": ("accel",),
    "gyro": ("gyro",),
    "accel+gyro": ("accel", "gyro"),
    "two accels": ("lower", "upper"),
}
TIP_SEEN_BY: dict[str, tuple[str, ...]] = {
    "nothing": (),
    "area": ("area",),
    "camera": ("camera",),
}
CONFIGURATIONS = list(product((5, 6), INERTIAL, TIP_SEEN_BY))

POSE = np.array([0.02, -0.03, 0.01, 0.7, 0.9, 0.4])
"""Tip, azimuth, elevation, spin."""
RATES = np.array([0.05, -0.08, 0.02, 1.3, -0.8, 0.9])
ACCELERATIONS = np.array([1.2, -0.7, 0.9, 2.5, 1.4, -2.0])
"""Of tip and angles; with six degrees of freedom of tip and body."""
STRAIGHT_UP = np.array([0.0, 0.0, 0.9, 2.5, 1.4, -2.0])
WHITE_JERK = white_jerk_motion(100.0, 1000.0)
"""Constant accelerations where there is no noise."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion that obeys the model exactly, with readings without noise."""

    model: StateSpaceModel
    measurements: list[Measurement]
    states: Array

    @property
    def observability(self) -> Observability:
        return observability(self.model, self.measurements, self.states)


def first_state(
    n_q: int,
    rates: Array | None = None,
    accelerations: Array | None = None,
    pose: Array = POSE,
) -> Array:
    """Return (q, q̇, q̈) of five degrees of freedom, or (p, σ, v, ω, a, α) of six."""
    zero = np.zeros(n_q)
    if n_q == 6:
        pose = np.concatenate([pose[:3], attitude_of(*pose[3:]).as_mrp()])
    blocks = [pose, zero if rates is None else rates]
    blocks.append(zero if accelerations is None else accelerations)
    return np.concatenate([block[:n_q] for block in blocks])


def attitude_of(azimuth: float, elevation: float, spin: float) -> Rotation:
    """Body to world: turned by the spin, leant from upright, turned by the azimuth."""
    return Rotation.from_euler("ZYZ", [azimuth, np.pi / 2 - elevation, spin])


def motion(model: StateSpaceModel, x: Array, times: Array) -> Motion:
    """Follow the model from a first state without process noise."""
    states = [x]
    for dt in np.diff(times):
        states.append(call(model.f, states[-1], np.zeros(model.n_w), dt))
    measurements = [
        Measurement(float(t), np.concatenate([call(sensor.h, x) for sensor in model.sensors]))
        for t, x in zip(times, states, strict=True)
    ]
    return Motion(model, measurements, np.array(states))


def configured(
    n_q: int, inertial: str, tip_seen_by: str, sensors: dict[str, Any] | None = None, **config: Any
) -> StateSpaceModel:
    names = INERTIAL[inertial] + TIP_SEEN_BY[tip_seen_by]
    config = {"motion": WHITE_JERK, **config}
    return pen_model(pen(n_q, sensors or SENSORS, **config), names, writing_area=False)


def second(n: int = 21) -> Array:
    return np.linspace(0.0, 1.0, n)
