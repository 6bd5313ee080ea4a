"""Simulated readings: what the sensors of a model read along a known motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.motions import Motion
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel

NEWTON_STEPS = 5


@dataclass(frozen=True, eq=False)
class SimulatedReadings:
    """Readings with the truth they came from.

    Parameters
    ----------
    sensors : name → (times (n,), values (n, n_y))
    time_s, states : (n,), (n, n_x): the true states at all instants
    """

    sensors: Mapping[str, tuple[Array, Array]]
    time_s: Array
    states: Array


def sample_times(model: StateSpaceModel, duration_s: float) -> dict[str, Array]:
    """Return each sensor's own sampling instants from 0 to the duration.

    Sensors without readings of their own (the writing area) have none.

    Raises
    ------
    InputError
        If a sensor has no rate, or the duration is not positive.
    """
    if not 0 < duration_s < np.inf:
        raise InputError(f"duration is {duration_s} s, expected a positive time")
    times = {}
    for sensor in model.measured_sensors:
        if sensor.rate_hz is None:
            raise InputError(f"sensor {sensor.name} has no rate_hz, expected one to simulate it")
        count = int(np.floor(duration_s * sensor.rate_hz + 1e-9)) + 1
        times[sensor.name] = np.round(np.arange(count) / sensor.rate_hz, 9)
    if not times:
        raise InputError("no sensor with readings to simulate, expected at least one")
    return times


def union_of_times(times: Mapping[str, Array]) -> Array:
    """Return all instants at which any sensor samples."""
    return np.unique(np.concatenate(list(times.values())))


def true_states(model: StateSpaceModel, motion: Motion, rng: np.random.Generator) -> Array:
    """Return the states (n, n_x) along a motion, biases drawn from the model.

    Biases start from the prior's spread and walk with the model's own noise.
    """
    n_q = 6 if "spin_rad" in model.state_names else 5
    states = np.zeros((len(motion.time_s), model.n_x))
    states[:, : 3 * n_q] = np.hstack(
        [block[:, :n_q] for block in (motion.q, motion.q_dot, motion.q_ddot)]
    )
    walking = slice(3 * n_q, model.n_x)
    states[0, walking] = rng.normal(0.0, model.prior.std[walking])
    for k, dt in enumerate(np.diff(motion.time_s)):
        noise = rng.standard_normal(model.n_w)
        states[k + 1, walking] = np.asarray(model.f(states[k], noise, dt)).ravel()[walking]
    return states


def noisy_reading(
    sensor: SensorModel, state: Array, noise: Array, slope: ca.Function | None = None
) -> Array:
    """Return the reading y (n_y,) whose residual at the true state is `noise` (n_r,).

    Solves ``residual(y, x) = noise`` by Newton's method from ``y = h(x)``: one
    step for a plain difference, a few where the residual is a rotation.
    """
    slope = slope or sensor.residual.jacobian()
    y = np.asarray(sensor.h(state)).ravel()
    for _ in range(NEWTON_STEPS):
        missing = noise - np.asarray(sensor.residual(y, state)).ravel()
        if np.abs(missing).max() <= 1e-12 * np.abs(noise).max():
            break
        jacobian = np.asarray(slope(y, state, np.zeros(sensor.n_r))[0])
        y = y + np.linalg.lstsq(jacobian, missing, rcond=None)[0]
    return y


def simulate_readings(
    model: StateSpaceModel,
    times: Mapping[str, Array],
    time_s: Array,
    states: Array,
    rng: np.random.Generator,
) -> SimulatedReadings:
    """Read every sensor at its own instants, with its noise and range.

    Parameters
    ----------
    times : sensor name → its instants, each one of `time_s`
    time_s, states : (n,), (n, n_x) the truth
    """
    sensors = {}
    for name, instants in times.items():
        sensor = model.sensor(name)
        slope = sensor.residual.jacobian()
        rows = np.searchsorted(time_s, instants)
        values = np.array(
            [
                noisy_reading(sensor, states[row], rng.normal(0.0, sensor.noise_std), slope)
                for row in rows
            ]
        )
        if sensor.reading_limit is not None:
            values = np.clip(values, -sensor.reading_limit, sensor.reading_limit)
        sensors[name] = (instants, values)
    return SimulatedReadings(sensors, time_s, states)
