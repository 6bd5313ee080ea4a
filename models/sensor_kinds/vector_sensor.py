"""What sensors of a vector share: axes, sensitivity, range and bias."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, field_validator, model_validator

from models.sensor_kinds.mounted import IDENTITY, Matrix3, MountedSensor, Vector3
from models.sensor_kinds.reading import BiasStates, SymbolicReading

Axis = Literal["x", "y", "z"]
_ROW: dict[Axis, int] = {"x": 0, "y": 1, "z": 2}


class VectorSensor(MountedSensor):
    """Reads a vector along its axes, in the unit that the concrete sensor names.

    ``y = sensitivity · v + bias + noise`` of a vector v along the sensor's nominal axes.

    Its fields end in `si_unit`: ``range_…``, ``resolution_…``, ``bias_…``, ``bias_std_…`` and
    ``bias_walk_…``. `bias` is what is known of the bias, per axis x, y, z. One that is known to a
    standard deviation `bias_std` > 0 only becomes a state (a random walk of density `bias_walk`)
    that begins there.

    Parameters
    ----------
    sensitivity : (3, 3) by rows: scales on its diagonal, misalignment beside it; as
        ``pen-mhe calibrate`` finds it, or the identity
    """

    si_unit: ClassVar[str]
    axes: tuple[Axis, ...] = Field(default=("x", "y", "z"), min_length=1)
    sensitivity: Matrix3 = IDENTITY

    @field_validator("sensitivity")
    @classmethod
    def _near_one(cls, value: Matrix3) -> Matrix3:
        if np.abs(np.array(value) - np.eye(3)).sum(axis=1).max() >= 1:
            raise ValueError("expected a matrix near the identity: scales near 1, the rest small")
        return value

    @field_validator("axes")
    @classmethod
    def _no_axis_twice(cls, value: tuple[Axis, ...]) -> tuple[Axis, ...]:
        if len(set(value)) < len(value):
            raise ValueError(f"expected each axis once, got {', '.join(value)}")
        return value

    @model_validator(mode="after")
    def _walk_has_a_start(self) -> Self:
        """Refuse a walk that nothing would walk: a bias of std 0 is no state."""
        std, walk = self.field_beginning("bias_std_"), self.field_beginning("bias_walk_")
        if getattr(self, walk) > 0 and getattr(self, std) == 0:
            raise ValueError(f"{walk} is given without {std}, expected a positive {std}")
        return self

    @model_validator(mode="after")
    def _range_has_steps(self) -> Self:
        """Refuse a quantiser of which every code is a limit of the range."""
        limit, step = self.field_beginning("range_"), self.field_beginning("resolution_")
        if getattr(self, limit) is not None and getattr(self, step) >= getattr(self, limit):
            raise ValueError(f"{step} is not below {limit}, expected a step within the range")
        return self

    @classmethod
    def field_beginning(cls, stem: str) -> str:
        """Return the concrete sensor's field that begins with a stem, whatever its unit."""
        return next(field for field in cls.model_fields if field.startswith(stem))

    def value_beginning(self, stem: str) -> Any:
        """Return the value of that field."""
        return getattr(self, self.field_beginning(stem))

    @property
    def bias(self) -> Vector3:
        """What is known of the bias, per axis x, y, z."""
        return getattr(self, f"bias_{self.si_unit}")

    @property
    def bias_walk(self) -> float:
        """Density of the bias' random walk, per √s."""
        return self.value_beginning("bias_walk_")

    @property
    def reading_limit(self) -> float | None:
        """Where its range ends; None where it has none."""
        return self.value_beginning("range_")

    @property
    def resolution(self) -> float:
        """Step between readings; 0 for one that is fine."""
        return self.value_beginning("resolution_")

    @property
    @abstractmethod
    def sample_std(self) -> float:
        """Standard deviation of a sample by noise and resolution."""

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """The axes, in the unit of the concrete sensor."""
        return tuple((axis, self.si_unit) for axis in self.axes)

    def bias_states(self, name: str) -> BiasStates:
        """Return a bias state per axis; none unless its initial std is positive."""
        std = self.value_beginning("bias_std_")
        if std == 0:
            return BiasStates()
        names = tuple(f"{name}_bias_{axis}_{self.si_unit}" for axis in self.axes)
        mean = tuple(self.bias[_ROW[axis]] for axis in self.axes)
        return BiasStates(names, self.si_unit, mean, std, self.bias_walk)

    def in_sensor_axes(self, body_vector: ca.SX, bias: ca.SX) -> SymbolicReading:
        """Return the reading of a vector (3,) in body axes along the sensor's axes.

        Parameters
        ----------
        bias : its bias states; empty where what is known of the bias is taken as exact
        """
        rows = [_ROW[axis] for axis in self.axes]
        h = ca.DM(self.sensor_to_body).T @ body_vector
        if self.sensitivity != IDENTITY:
            h = ca.DM(self.sensitivity) @ h
        h = h[rows]
        if bias.numel():
            h = h + bias
        elif any(self.bias):
            h = h + ca.DM(self.bias)[rows]
        return SymbolicReading(
            h,
            np.full(len(rows), self.sample_std),
            reading_limit=self.reading_limit,
            resolution=self.resolution,
        )
