"""Readings of a pen that writes the same loop for ever, in as many parts as wanted."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from models.arrays import Array
from models.pen import pen_model
from models.state_space import StateSpaceModel
from tests.estimation.pens import pen_config

RATE_HZ, LOOP_S = 100.0, 4.0
PER_LOOP = int(RATE_HZ * LOOP_S)
PER_PART = 10_000
"""A whole number of loops."""
AREA_EVERY = 10
"""The writing area speaks at every tenth sample."""

TURN = 2 * np.pi / LOOP_S
AMPLITUDE = np.array([0.03, 0.02, 0.002, 0.3, 0.1])
PHASE = np.array([0.0, np.pi / 2, 0.3, 1.0, 2.0])
MIDDLE = np.array([0.0, 0.0, 0.0, 0.4, 1.0])


def model() -> StateSpaceModel:
    """A pen of 15 states with accelerometer, gyroscope and writing area."""
    return pen_model(pen_config(), ["accel", "gyro"])


def loop_states() -> Array:
    """True states (PER_LOOP, 15) of one loop."""
    angle = TURN * np.arange(PER_LOOP)[:, None] / RATE_HZ + PHASE
    position = MIDDLE + AMPLITUDE * np.sin(angle)
    velocity, acceleration = (
        TURN * AMPLITUDE * np.cos(angle),
        -(TURN**2) * AMPLITUDE * np.sin(angle),
    )
    return np.hstack([position, velocity, acceleration])


def parts(n_parts: int) -> Iterator[tuple[Array, Array]]:
    """Yield times (PER_PART,) and readings (PER_PART, n_y); noise is drawn part by part."""
    pen = model()
    clean = np.array(
        [np.concatenate([np.asarray(s.h(x)).ravel() for s in pen.sensors]) for x in loop_states()]
    )
    area = pen.stack({"area": pen.sensor("area").constant_reading})
    columns = ~np.isnan(area)
    measured = np.concatenate([s.noise_std for s in pen.measured_sensors])
    for part in range(n_parts):
        rows = part * PER_PART + np.arange(PER_PART)
        y = clean[rows % PER_LOOP]
        noise = np.random.default_rng(part).standard_normal((PER_PART, len(measured)))
        y[:, ~columns] += measured * noise
        y[:, columns] = np.where(rows[:, None] % AREA_EVERY == 0, area[columns], np.nan)
        yield rows / RATE_HZ, y
