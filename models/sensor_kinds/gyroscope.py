"""Angular rate about the axes of a sensor."""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
from pydantic import PositiveFloat

from models.sensor_kinds.inertial import InertialSensor
from models.sensor_kinds.mounted import NonNegative, Vector3
from models.sensor_kinds.reading import MovingBody, SymbolicReading


class Gyroscope(InertialSensor):
    """Angular rate about its axes, rad/s."""

    reads_rate: ClassVar[bool] = True
    si_unit: ClassVar[str] = "rad_s"
    kind: Literal["gyroscope"] = "gyroscope"
    noise_density_rad_s_per_sqrt_hz: PositiveFloat
    range_rad_s: PositiveFloat | None = None
    resolution_rad_s: NonNegative = 0.0
    bias_rad_s: Vector3 = (0.0, 0.0, 0.0)
    bias_std_rad_s: NonNegative = 0.0
    bias_walk_rad_s_per_sqrt_s: NonNegative = 0.0

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return the body rate."""
        return self.in_sensor_axes(body.rigid.body_rate(), bias)
