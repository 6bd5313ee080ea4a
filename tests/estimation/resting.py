"""Inertial readings of a pen with a sensor of rest, made directly, and what is found from them."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from estimation.rest_detector import RestDetector
from models.arrays import Array
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import as_pen
from models.sensor_kinds.table import SENSOR_KINDS
from models.state_space import StateSpaceModel

INERTIAL = ("accel", "gyro")
UP = np.array([0.6, 0.0, 0.8])
RATE_HZ = 100.0


def pen_without_rest(pen: str = "reference") -> PenConfig:
    """Return a bundled pen without a sensor of rest, by its name."""
    config = as_pen(pen)
    sensors = {name: sensor for name, sensor in config.sensors.items() if not sensor.is_rest}
    return config.model_copy(update={"sensors": sensors})


def pen_at_rest(pen: str = "reference", **fields: Any) -> PenConfig:
    """Return a bundled pen with a sensor of rest of its own, ``still``."""
    config = pen_without_rest(pen)
    rest = SENSOR_KINDS["rest"].model_validate({"kind": "rest", **fields})
    return config.model_copy(update={"sensors": {**config.sensors, "still": rest}})


@functools.cache
def model_at_rest(**fields: Any) -> StateSpaceModel:
    """Return the reference pen's model with accelerometer, gyroscope and rest."""
    return pen_model(pen_at_rest(**fields), INERTIAL)


def inertial(
    model: StateSpaceModel,
    time_s: Array,
    seed: int,
    *,
    acceleration: Array | float = 0.0,
    rate: Array | float = 0.0,
    bias_rad_s: Array | float = 0.0,
) -> Array:
    """Return stacked readings (n, n_y): gravity along `UP` and what moves, noise, steps.

    Parameters
    ----------
    acceleration, rate : what is added to the accelerometers' and the gyroscopes' axes
    """
    rng = np.random.default_rng(seed)
    y = np.full((len(time_s), model.n_y), np.nan)
    start = 0
    for sensor in model.sensors:
        own = slice(start, start + sensor.n_y)
        start += sensor.n_y
        if not (sensor.feels_gravity or sensor.reads_rate):
            continue
        true = 9.81 * UP + acceleration if sensor.feels_gravity else bias_rad_s + rate
        noise = sensor.drawn_std * rng.standard_normal((len(time_s), sensor.n_y))
        y[:, own] = true + noise
        if sensor.resolution:
            y[:, own] = sensor.resolution * np.round(y[:, own] / sensor.resolution)
    return y


def columns(model: StateSpaceModel, name: str) -> slice:
    """Return the columns of a sensor's readings."""
    start = 0
    for sensor in model.sensors:
        if sensor.name == name:
            return slice(start, start + sensor.n_y)
        start += sensor.n_y
    raise KeyError(name)


def rests(model: StateSpaceModel, time_s: Array, y: Array) -> Array:
    """Return at which instants (n,) the detector says that the pen rests."""
    detector = RestDetector(model)
    memory, found = detector.first(), np.zeros(len(time_s), dtype=bool)
    for k, dt in enumerate(np.diff(time_s, prepend=time_s[0])):
        memory, filled = detector.step(memory, float(dt), y[k])
        found[k] = np.isfinite(filled[columns(model, "still")]).all()
    return found


def instants(duration_s: float, rate_hz: float = RATE_HZ) -> Array:
    """Return equal instants (n,) from 0 on."""
    return np.arange(int(duration_s * rate_hz)) / rate_hz
