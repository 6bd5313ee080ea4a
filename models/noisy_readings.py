"""What a sensor makes of the truth: noise, a quantiser, a range."""

from __future__ import annotations

import numpy as np

from models.arrays import Array
from models.sensor_model import SensorModel

NEWTON_STEPS = 5
TOUCHING_STDS = 2.0
ROUNDING = 1e-12
"""Noise is met to this part of its largest component."""


def noisy_readings(
    sensor: SensorModel, states: Array, noise: Array, *, inputs: Array | None = None
) -> Array:
    """Return the readings y (n, n_y) whose residuals at the true states are `noise`.

    Solves ``residual(y, x) = noise`` by Newton's method from ``y = h(x)``: one
    step for a plain difference, a few where the residual is a rotation.

    Parameters
    ----------
    states : (n, n_x) true states at the sensor's instants
    noise : (n, n_r) in the units of the residual's rows; zero gives h(x)
    inputs : (n, n_u) of the model, where the sensor reads them
    """
    if not len(states):
        return np.zeros((0, sensor.n_y))
    at = states.T, *sensor.inputs_of(None if inputs is None else inputs.T)
    y = sensor.h(*at).full()
    slope = sensor.residual.jacobian()
    for _ in range(NEWTON_STEPS):
        missing = noise.T - sensor.residual(y, *at).full()
        if np.abs(missing).max() <= ROUNDING * np.abs(noise).max():
            break
        # CasADi evaluates column by column and lays the Jacobians side by side.
        jacobians = slope(y, *at, np.zeros_like(missing))[0].full()
        jacobians = jacobians.reshape(sensor.n_r, len(states), sensor.n_y).swapaxes(0, 1)
        y = y + np.einsum("nij,jn->in", np.linalg.pinv(jacobians), missing)
    return np.asarray(y.T)


def touching(sensor: SensorModel, states: Array) -> Array:
    """Return the readings (n, 1) of a contact: its height while the tip touches, else NaN.

    The tip touches where it is within `TOUCHING_STDS` deviations of the height.
    """
    away = sensor.h(states.T).full().T - sensor.touched_height
    touches = np.abs(away) <= TOUCHING_STDS * sensor.noise_std
    return np.where(touches, float(sensor.touched_height or 0.0), np.nan)


def digitised(sensor: SensorModel, values: Array) -> Array:
    """Return readings (n, n_y) rounded to the sensor's resolution, then clipped to its range."""
    if sensor.resolution > 0:
        values = np.round(values / sensor.resolution) * sensor.resolution
    if sensor.reading_limit is not None:
        values = np.clip(values, -sensor.reading_limit, sensor.reading_limit)
    return values
