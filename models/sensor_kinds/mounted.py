"""Sensors as data: what is mounted on the pen, where, and how good it is.

A kind of sensor is a file in this folder, with its data and what it reads, and a row of
`models.sensor_kinds.table.KINDS`. What others want to know of a sensor is a column here;
nothing asks which kind it is.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field, PositiveFloat, field_validator

from models.config import UnitConfig
from models.sensor_kinds.reading import BiasStates, MovingBody, SymbolicReading

Vector3 = tuple[float, float, float]
Matrix3 = tuple[Vector3, Vector3, Vector3]
NonNegative = Annotated[float, Field(ge=0)]

IDENTITY: Matrix3 = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
ROTATION_TOLERANCE = 1e-6


class SensorBase(UnitConfig):
    """What every sensor has.

    Parameters
    ----------
    rate_hz : nominal sampling rate, Hz; used by the simulator and by sensors
        without readings of their own, estimators go by the time stamps
    delay_s : time from capture to arrival, s
    dropout_fraction : part of the samples that get lost, each by itself; used by the
        simulator only
    huber : threshold, in standard deviations of the whole reading, beyond which it moves an
        estimate no further; smaller trusts a reading far off less, None trusts all alike
    gate_probability : readings beyond this χ² quantile of their distance from a prediction are
        dropped, by estimators that have gates; None drops none
    usual_innovations : the largest of the statistics of innovations that a watch keeps, on most
        clean data: `estimation.watch.limits.USUAL`; None takes what chance explains
    sees_pose : whether it reads position, m, and rotation vector, rad, of a target
    feels_gravity : whether it reads specific force, m/s², along its axes
    reads_rate : whether it reads angular rates, rad/s, about its axes
    reads_touch : whether it reads the height of a plane, and only while the tip touches it
    is_rest : whether it reads zero angular rate, and only while the body rests
    sees_north : whether it reads a field of the world that has a heading
    is_disturbed : whether its surroundings disturb it often: a watch suspects it first
    is_mounted : whether it has a place and an orientation, as a `MountedSensor`
    """

    sees_pose: ClassVar[bool] = False
    feels_gravity: ClassVar[bool] = False
    reads_rate: ClassVar[bool] = False
    reads_touch: ClassVar[bool] = False
    is_rest: ClassVar[bool] = False
    sees_north: ClassVar[bool] = False
    is_disturbed: ClassVar[bool] = False
    is_mounted: ClassVar[bool] = False
    if TYPE_CHECKING:
        kind: str
    rate_hz: PositiveFloat | None = None
    delay_s: NonNegative = 0.0
    dropout_fraction: Annotated[float, Field(ge=0, lt=1)] = 0.0
    huber: PositiveFloat | None = None
    gate_probability: Annotated[float, Field(gt=0, lt=1)] | None = None
    usual_innovations: (
        Annotated[tuple[PositiveFloat, ...], Field(min_length=5, max_length=5)] | None
    ) = None

    @property
    @abstractmethod
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """(axis, SI unit) of each component of a reading.

        ``(("x", "m_s2"), …)`` for an accelerometer; the units are keys of `models.units.UNITS`.
        """

    @abstractmethod
    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return what the sensor reads on a body, in symbols of the state.

        Parameters
        ----------
        bias : the sensor's bias states, as many as `bias_states` names
        """

    @property
    def sees_position(self) -> bool:
        """Whether the tip's position stays bounded with this sensor."""
        return False

    @property
    def may_be_silent(self) -> bool:
        """Whether a whole recording may have no reading of it, though it has its columns."""
        return self.reads_touch or self.is_rest

    @property
    def field_strength(self) -> float | None:
        """Strength of the magnetic field that it reads, µT; None for others."""
        return None

    @property
    def place_m(self) -> Vector3 | None:
        """Where the tip is, for a sensor that says so without a reading; None for others."""
        return None

    @property
    def makes_readings(self) -> bool:
        """Whether estimators make its readings from those of others, so that nobody gives any."""
        return False

    def bias_states(self, name: str) -> BiasStates:
        """Return the bias states of the sensor of this name; none for most kinds."""
        return BiasStates()


class MountedSensor(SensorBase):
    """A sensor at a place and in an orientation on the pen.

    Parameters
    ----------
    position_m : from the tip, in body axes (z from tip to top), m
    sensor_to_body : rotation matrix by rows, v_body = sensor_to_body · v_sensor
    """

    is_mounted: ClassVar[bool] = True
    position_m: Vector3 = (0.0, 0.0, 0.0)
    sensor_to_body: Matrix3 = IDENTITY

    @field_validator("sensor_to_body")
    @classmethod
    def _is_rotation(cls, value: Matrix3) -> Matrix3:
        matrix = np.array(value)
        if np.abs(matrix @ matrix.T - np.eye(3)).max() > ROTATION_TOLERANCE:
            raise ValueError("expected a rotation matrix: its rows are not orthonormal")
        if np.linalg.det(matrix) < 0:
            raise ValueError("expected a rotation matrix: its determinant is -1, a reflection")
        return value
