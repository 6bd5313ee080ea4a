"""The Earth's magnetic field along the axes of a sensor."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import casadi as ca
from pydantic import Field, PositiveFloat

from models.level import Vector3, from_gravity_frame
from models.sensor_kinds.mounted import NonNegative
from models.sensor_kinds.reading import MovingBody, SymbolicReading
from models.sensor_kinds.vector_sensor import VectorSensor
from models.sensor_model import quantiser_variance


class Magnetometer(VectorSensor):
    """The field of the Earth along its axes, µT.

        B = F (cos I cos A, cos I sin A, -sin I)      in gravity's frame, z up

    Iron that turns with the pen is a bias (hard) and a sensitivity (soft), as ``pen-mhe calibrate
    magnetometer`` finds them.

    Parameters
    ----------
    field_strength_ut, field_dip_rad : F and I of the place, I downward; a geomagnetic model has
        them (``ngdc.noaa.gov/geomag``). Towards a dip of 90° less of azimuth is seen
    field_azimuth_rad : A, the azimuth of magnetic north. 0 counts azimuths from it; where x is true
        north, it is minus the declination
    noise_std_ut : of a sample in each axis; larger trusts it less
    """

    sees_north: ClassVar[bool] = True
    is_disturbed: ClassVar[bool] = True
    si_unit: ClassVar[str] = "ut"
    kind: Literal["magnetometer"] = "magnetometer"
    field_strength_ut: PositiveFloat
    field_dip_rad: Annotated[float, Field(ge=-math.pi / 2, le=math.pi / 2)]
    field_azimuth_rad: float = 0.0
    noise_std_ut: PositiveFloat
    range_ut: PositiveFloat | None = None
    resolution_ut: NonNegative = 0.0
    bias_ut: Vector3 = (0.0, 0.0, 0.0)
    bias_std_ut: NonNegative = 0.0
    bias_walk_ut_per_sqrt_s: NonNegative = 0.0

    @property
    def sample_std(self) -> float:
        """Standard deviation of a sample by noise and resolution."""
        return math.sqrt(self.noise_std_ut**2 + quantiser_variance(self.resolution))

    @property
    def field_strength(self) -> float:
        """That of the Earth, µT."""
        return self.field_strength_ut

    def field_ut(self, up: Vector3) -> Vector3:
        """Return the field in the axes of a paper whose upward direction is `up`."""
        level = self.field_strength_ut * math.cos(self.field_dip_rad)
        north = level * math.cos(self.field_azimuth_rad), level * math.sin(self.field_azimuth_rad)
        down = self.field_strength_ut * math.sin(self.field_dip_rad)
        return from_gravity_frame((*north, -down), up)

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return the field in body axes, wherever the sensor is."""
        field = body.rigid.world_to_body @ ca.DM(self.field_ut(body.up))
        return self.in_sensor_axes(field, bias)
