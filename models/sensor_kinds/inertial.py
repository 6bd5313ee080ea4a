"""What accelerometer and gyroscope share: noise, range and bias of one axis each."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, PositiveFloat, field_validator, model_validator

from models.sensor_kinds.mounted import MountedSensor
from models.sensor_kinds.reading import BiasStates, SymbolicReading
from models.sensor_model import quantiser_variance

Axis = Literal["x", "y", "z"]
_ROW: dict[Axis, int] = {"x": 0, "y": 1, "z": 2}


def sample_noise_std(density: float, bandwidth_hz: float) -> float:
    """Return the standard deviation of one sample behind a single-pole filter.

    ``σ = density · √(π/2 · bandwidth)``: π/2 is the ratio of the noise
    bandwidth of a single pole to its -3 dB frequency.
    """
    return density * math.sqrt(math.pi / 2 * bandwidth_hz)


class InertialSensor(MountedSensor):
    """Noise and bias of one axis, in the unit that the concrete sensor names.

    Its fields end in `si_unit`: ``noise_density_…``, ``range_…``, ``resolution_…``,
    ``bias_std_…`` and ``bias_walk_…``. The noise of a sample is white, with the density
    behind a single pole of `bandwidth_hz`. A bias that starts with standard deviation
    `bias_std` > 0 becomes a state (a random walk of density `bias_walk`).
    """

    si_unit: ClassVar[str]
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

    def _value(self, stem: str) -> Any:
        return getattr(self, self._field(stem))

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """The axes, in the unit of the concrete sensor."""
        return tuple((axis, self.si_unit) for axis in self.axes)

    def bias_states(self, name: str) -> BiasStates:
        """Return a bias state per axis; none unless its initial std is positive."""
        std = self._value("bias_std_")
        if std == 0:
            return BiasStates()
        names = tuple(f"{name}_bias_{axis}_{self.si_unit}" for axis in self.axes)
        return BiasStates(names, self.si_unit, std, self._value("bias_walk_"))

    def in_sensor_axes(self, body_vector: ca.SX, bias: ca.SX) -> SymbolicReading:
        """Return the reading of a vector (3,) in body axes along the sensor's axes."""
        rows = [_ROW[axis] for axis in self.axes]
        in_sensor_axes = ca.DM(self.sensor_to_body).T @ body_vector
        h = in_sensor_axes[rows]
        if bias.numel():
            h = h + bias
        sample_std = sample_noise_std(self._value("noise_density_"), self.bandwidth_hz)
        resolution = self._value("resolution_")
        variance = sample_std**2 + quantiser_variance(resolution)
        noise_std = np.full(len(rows), np.sqrt(variance))
        return SymbolicReading(
            h, noise_std, reading_limit=self._value("range_"), resolution=resolution
        )
