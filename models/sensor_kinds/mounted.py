"""Sensors as data: what is mounted on the pen, where, and how good it is.

A sensor never becomes a class of model or estimator: `models.sensor_kinds.table`
turns any of these into symbolic readings.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, PositiveFloat, field_validator

from models.config import UnitConfig

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
    sees_position : whether the tip's position stays bounded with this sensor
    """

    sees_position: ClassVar[bool] = False
    rate_hz: PositiveFloat | None = None
    delay_s: NonNegative = 0.0
    dropout_fraction: Annotated[float, Field(ge=0, lt=1)] = 0.0


class MountedSensor(SensorBase):
    """A sensor at a place and in an orientation on the pen.

    Parameters
    ----------
    position_m : from the tip, in body axes (z from tip to top), m
    sensor_to_body : rotation matrix by rows, v_body = sensor_to_body · v_sensor
    """

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
