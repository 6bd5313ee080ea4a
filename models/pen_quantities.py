"""What of a pen a sensor of one's own may read, in symbols of its state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from models.sensor_kinds.reading import MovingBody

Place = ca.SX | Sequence[float]
"""A point in body axes (3,), m, from the tip; z is towards the top."""


@dataclass(frozen=True, eq=False)
class PenQuantities:
    """A pen's tip, attitude and rates; vectors are in the axes of the paper unless they say body.

    Parameters
    ----------
    body : in symbols of the state
    """

    body: MovingBody

    @property
    def tip(self) -> ca.SX:
        """Position (3,) of the tip, m."""
        return self.body.rigid.tip

    @property
    def tip_velocity(self) -> ca.SX:
        """Velocity (3,) of the tip, m/s."""
        return self.body.rigid.tip_velocity

    @property
    def tip_acceleration(self) -> ca.SX:
        """Acceleration (3,) of the tip, m/s²."""
        return self.body_to_world @ self.body.rigid.specific_force(ca.SX.zeros(3), 0.0)

    @property
    def body_to_world(self) -> ca.SX:
        """Rotation (3, 3) from body axes to those of the paper."""
        return self.body.rigid.world_to_body.T

    @property
    def axis(self) -> ca.SX:
        """Unit vector (3,) from the tip to the top."""
        return self.body_to_world[:, 2]

    @property
    def azimuth(self) -> ca.SX:
        """Azimuth of the axis, rad."""
        return ca.atan2(self.axis[1], self.axis[0])

    @property
    def elevation(self) -> ca.SX:
        """Elevation of the axis, rad."""
        return ca.asin(self.axis[2])

    @property
    def body_rate(self) -> ca.SX:
        """Angular rate (3,) in body axes, rad/s."""
        return self.body.rigid.body_rate()

    def point(self, place: Place) -> ca.SX:
        """Return the position (3,) of a point of the pen, m."""
        return self.body.rigid.point(_column(place))

    def velocity(self, place: Place) -> ca.SX:
        """Return the velocity (3,) of a point of the pen, m/s."""
        return self.tip_velocity + self.body_to_world @ ca.cross(self.body_rate, _column(place))

    def specific_force(self, place: Place) -> ca.SX:
        """Return what an accelerometer at a point of the pen reads in body axes (3,), m/s²."""
        body = self.body
        return body.rigid.specific_force(_column(place), body.gravity_m_s2, up=body.up)


def _column(place: Place) -> ca.SX:
    return place if isinstance(place, ca.SX) else ca.SX(ca.DM(list(place)))
