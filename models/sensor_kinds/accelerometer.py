"""Specific force along the axes of a sensor."""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
from pydantic import PositiveFloat

from models.sensor_kinds.inertial import InertialSensor
from models.sensor_kinds.mounted import NonNegative, Vector3
from models.sensor_kinds.reading import MovingBody, SymbolicReading


class Accelerometer(InertialSensor):
    """Specific force along its axes, m/s²: at rest +g along the upward direction."""

    feels_gravity: ClassVar[bool] = True
    si_unit: ClassVar[str] = "m_s2"
    kind: Literal["accelerometer"] = "accelerometer"
    noise_density_m_s2_per_sqrt_hz: PositiveFloat
    range_m_s2: PositiveFloat | None = None
    resolution_m_s2: NonNegative = 0.0
    bias_m_s2: Vector3 = (0.0, 0.0, 0.0)
    bias_std_m_s2: NonNegative = 0.0
    bias_walk_m_s2_per_sqrt_s: NonNegative = 0.0

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return the specific force at the sensor's place."""
        place = ca.SX(self.position_m)
        force = body.rigid.specific_force(place, body.gravity_m_s2, up=body.up)
        return self.in_sensor_axes(force, bias)
