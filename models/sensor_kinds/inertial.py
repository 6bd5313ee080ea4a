"""Accelerometer and gyroscope: noise, range and bias of one axis each."""

from __future__ import annotations

import math
from typing import Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, PositiveFloat, field_validator, model_validator

from models.arrays import Array
from models.sensor_kinds.mounted import MountedSensor, NonNegative
from models.sensor_kinds.reading import MovingBody, SymbolicReading
from models.sensor_model import quantiser_variance

Axis = Literal["x", "y", "z"]


def sample_noise_std(density: float, bandwidth_hz: float) -> float:
    """Return the standard deviation of one sample behind a single-pole filter.

    ``σ = density · √(π/2 · bandwidth)``: π/2 is the ratio of the noise
    bandwidth of a single pole to its -3 dB frequency.
    """
    return density * math.sqrt(math.pi / 2 * bandwidth_hz)


class InertialSensor(MountedSensor):
    """Noise and bias of one axis, in the unit that the concrete sensor names.

    The noise of a sample is white, with the density behind a single pole of
    `bandwidth_hz`. A bias that starts with standard deviation `bias_std` > 0
    becomes a state (a random walk of density `bias_walk`).
    """

    axes: tuple[Axis, ...] = Field(default=("x", "y", "z"), min_length=1)
    bandwidth_hz: PositiveFloat

    @field_validator("axes")
    @classmethod
    def _no_axis_twice(cls, value: tuple[Axis, ...]) -> tuple[Axis, ...]:
        if len(set(value)) < len(value):
            raise ValueError(f"expected each axis once, got {', '.join(value)}")
        return value

    @model_validator(mode="after")
    def _walk_has_a_start(self) -> Self:
        """Refuse a walk that nothing would walk: a bias of std 0 is no state."""
        std, walk = self._field("bias_std_"), self._field("bias_walk_")
        if getattr(self, walk) > 0 and getattr(self, std) == 0:
            raise ValueError(f"{walk} is given without {std}, expected a positive {std}")
        return self

    @model_validator(mode="after")
    def _range_has_steps(self) -> Self:
        """Refuse a quantiser of which every code is a limit of the range."""
        limit, step = self._field("range_"), self._field("resolution_")
        if getattr(self, limit) is not None and getattr(self, step) >= getattr(self, limit):
            raise ValueError(f"{step} is not below {limit}, expected a step within the range")
        return self

    @classmethod
    def _field(cls, stem: str) -> str:
        """Return the concrete sensor's field that begins with a stem, whatever its unit."""
        return next(field for field in cls.model_fields if field.startswith(stem))


class Accelerometer(InertialSensor):
    """Specific force along its axes, m/s²: at rest +g along the upward direction."""

    kind: Literal["accelerometer"] = "accelerometer"
    noise_density_m_s2_per_sqrt_hz: PositiveFloat
    range_m_s2: PositiveFloat | None = None
    resolution_m_s2: NonNegative = 0.0
    bias_std_m_s2: NonNegative = 0.0
    bias_walk_m_s2_per_sqrt_s: NonNegative = 0.0


class Gyroscope(InertialSensor):
    """Angular rate about its axes, rad/s."""

    kind: Literal["gyroscope"] = "gyroscope"
    noise_density_rad_s_per_sqrt_hz: PositiveFloat
    range_rad_s: PositiveFloat | None = None
    resolution_rad_s: NonNegative = 0.0
    bias_std_rad_s: NonNegative = 0.0
    bias_walk_rad_s_per_sqrt_s: NonNegative = 0.0


_AXIS = {"x": 0, "y": 1, "z": 2}


def _inertial(
    sensor: InertialSensor, body_vector: ca.SX, bias: ca.SX, density: float, resolution: float
) -> tuple[ca.SX, Array]:
    rows = [_AXIS[axis] for axis in sensor.axes]
    in_sensor_axes = ca.DM(sensor.sensor_to_body).T @ body_vector
    h = in_sensor_axes[rows]
    if bias.numel():
        h = h + bias
    variance = sample_noise_std(density, sensor.bandwidth_hz) ** 2 + quantiser_variance(resolution)
    return h, np.full(len(rows), np.sqrt(variance))


def accelerometer_reading(sensor: Accelerometer, body: MovingBody, bias: ca.SX) -> SymbolicReading:
    """Return the specific force at the sensor's place."""
    force = body.rigid.specific_force(ca.SX(sensor.position_m), body.gravity_m_s2)
    h, noise_std = _inertial(
        sensor, force, bias, sensor.noise_density_m_s2_per_sqrt_hz, sensor.resolution_m_s2
    )
    return SymbolicReading(
        h, noise_std, reading_limit=sensor.range_m_s2, resolution=sensor.resolution_m_s2
    )


def gyroscope_reading(sensor: Gyroscope, body: MovingBody, bias: ca.SX) -> SymbolicReading:
    """Return the body rate."""
    h, noise_std = _inertial(
        sensor,
        body.rigid.body_rate(),
        bias,
        sensor.noise_density_rad_s_per_sqrt_hz,
        sensor.resolution_rad_s,
    )
    return SymbolicReading(
        h, noise_std, reading_limit=sensor.range_rad_s, resolution=sensor.resolution_rad_s
    )
