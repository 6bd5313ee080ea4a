"""What a calibrated pen file knows beside its sensors, and the same pen without one part of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from models.pen_config import PenConfig
from models.pen_file import parse_pen
from models.plane import LEVEL_PLANE

SHEETS: Mapping[str, str] = MappingProxyType(
    {"accelerometer": "LSM6DS3-accelerometer", "gyroscope": "LSM6DS3-gyroscope"}
)
"""Kind of an inertial sensor of the recorded pen → the preset with its data sheet."""


def _with_sensors(pen: PenConfig, change: Callable[[Any], Mapping[str, Any]]) -> PenConfig:
    changed = {
        name: sensor.model_copy(update=dict(change(sensor))) for name, sensor in pen.sensors.items()
    }
    return pen.model_copy(update={"sensors": MappingProxyType(changed)})


def without_slope(pen: PenConfig) -> PenConfig:
    """Return a pen whose paper is flat in the frame of its camera."""
    return _with_sensors(pen, lambda s: {"slope": LEVEL_PLANE} if s.reads_touch else {})


def without_level(pen: PenConfig) -> PenConfig:
    """Return a pen whose paper is level."""
    return pen.model_copy(update={"level_rad": (0.0, 0.0)})


def without_bias(pen: PenConfig) -> PenConfig:
    """Return a pen whose accelerometer is known to have no bias."""
    none = {"bias_std_m_s2": 0.0, "bias_walk_m_s2_per_sqrt_s": 0.0}
    return _with_sensors(pen, lambda s: none if s.feels_gravity else {})


def without_mounting(pen: PenConfig) -> PenConfig:
    """Return a pen whose inertial sensors are along its axes, as drawn."""

    def as_drawn(sensor: Any) -> Mapping[str, Any]:
        if not (sensor.feels_gravity or sensor.reads_rate):
            return {}
        along = np.round(np.array(sensor.sensor_to_body))
        return {"sensor_to_body": tuple(tuple(map(float, row)) for row in along)}

    return _with_sensors(pen, as_drawn)


def without_noise(pen: PenConfig) -> PenConfig:
    """Return a pen whose inertial sensors are as good as their data sheets say."""

    def of_sheet(sensor: Any) -> Mapping[str, Any]:
        if sensor.kind not in SHEETS:
            return {}
        preset = {"it": {"preset": SHEETS[sensor.kind]}}
        sheet = parse_pen({"name": "data sheet", "sensors": preset}).sensors["it"]
        return {key: value for key, value in sheet if key.startswith("noise_density")}

    return _with_sensors(pen, of_sheet)


def without_loss(pen: PenConfig) -> PenConfig:
    """Return a pen whose readings all weigh by least squares."""
    return _with_sensors(pen, lambda s: {"huber": None, "gate_probability": None})


INGREDIENTS: Mapping[str, Callable[[PenConfig], PenConfig]] = MappingProxyType(
    {
        "slope": without_slope,
        "level": without_level,
        "mounting": without_mounting,
        "tuned noise": without_noise,
        "loss": without_loss,
    }
)
"""What a pen file knows → the pen without it. A contact is left out by the choice of sensors."""
