"""What a camera tells of a pen beside its motion, as numbers that a model's sensors read with.

    frames      captured at their stamp + time offset
    IMU         turned on the pen by a rotation vector t (body axes) and moved by a lever d:
                Exp(t)ᵀ ω,   Exp(t)ᵀ f(place + d)
    gravity     up = Exp(level + l) e_z, in axes of the paper
    paper       z = height + h + (slope + s) · (x, y)

All are changes of what the pen file says, zero where it is right. All inertial sensors are
turned and moved together: a camera does not tell one from the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from models.kinematics import Body
from models.level import UP, Vector2, Vector3
from models.pen_config import PenConfig
from models.rotation import rotation_matrix


@dataclass(frozen=True)
class MountingQuantity:
    """A row of `QUANTITIES`.

    Parameters
    ----------
    name, unit : for people
    axes : of its numbers
    factor : from SI to the unit
    plausible_std : how far a pen file may be off, SI: what is known of a number before; larger
        lets poor data move it farther
    needs : field of the sensors without which nothing tells it, see
        `models.sensor_kinds.mounted.SensorBase`
    """

    name: str
    axes: tuple[str, ...]
    unit: str
    factor: float
    plausible_std: float
    needs: str = "is_mounted"


_DEG = math.degrees(1.0)
OFFSET, TURN, LEVER, LEVEL, SLOPE, HEIGHT = QUANTITIES = (
    MountingQuantity("time offset", ("",), "ms", 1e3, 0.02),
    MountingQuantity("turn", ("x", "y", "z"), "deg", _DEG, math.radians(5.0)),
    MountingQuantity("lever", ("x", "y", "z"), "mm", 1e3, 0.02, "feels_gravity"),
    MountingQuantity("level", ("x", "y"), "deg", _DEG, math.radians(2.0), "feels_gravity"),
    MountingQuantity("slope", ("x", "y"), "mm/m", 1e3, 0.03, "reads_touch"),
    MountingQuantity("height", ("",), "mm", 1e3, 0.005, "reads_touch"),
)
"""In the order in which their numbers stand."""


@dataclass(frozen=True)
class Number:
    """One number of a quantity: its axis is an index of the quantity's axes."""

    quantity: MountingQuantity
    axis: int

    @property
    def name(self) -> str:
        """For people: ``turn x``."""
        return f"{self.quantity.name} {self.quantity.axes[self.axis]}".rstrip()


def numbers_of(pen: PenConfig, sensors: Sequence[str]) -> tuple[Number, ...]:
    """Return the numbers that a pen with some of its sensors has."""
    used = [pen.sensors[name] for name in sensors]
    return tuple(
        Number(quantity, axis)
        for quantity in QUANTITIES
        if any(getattr(sensor, quantity.needs) for sensor in used)
        for axis in range(len(quantity.axes))
    )


def split(numbers: Sequence[Number], values: ca.SX) -> dict[MountingQuantity, list[Any]]:
    """Return quantity → its symbols, zero where there are none."""
    found: dict[MountingQuantity, list[Any]] = {q: [0.0] * len(q.axes) for q in QUANTITIES}
    for i, number in enumerate(numbers):
        found[number.quantity][number.axis] = values[i]
    return found


@dataclass(frozen=True)
class MountedBody:
    """A rigid body as sensors read it that are mounted otherwise than told.

    Parameters
    ----------
    rigid : at a reading's stamp
    seen : at the instant at which a frame is captured
    level_rad : of the pen file
    by : quantity → symbols, or zeros
    """

    rigid: Body
    seen: Body
    level_rad: Vector2
    by: Mapping[MountingQuantity, list[Any]]

    @property
    def tip(self) -> ca.SX:
        """World position (3,) less the paper's rise: what contact reads."""
        tip, slope, height = self.rigid.tip, self.by[SLOPE], self.by[HEIGHT][0]
        rise = slope[0] * tip[0] + slope[1] * tip[1] + height
        return ca.vertcat(tip[:2], tip[2] - rise)

    @property
    def tip_velocity(self) -> ca.SX:
        """World velocity (3,) of the tip."""
        return self.rigid.tip_velocity

    @property
    def world_to_body(self) -> ca.SX:
        """B (3, 3) of a frame."""
        return self.seen.world_to_body

    def point(self, mounting: ca.SX) -> ca.SX:
        """Return the world position (3,) of a point in a frame."""
        return self.seen.point(mounting)

    def specific_force(self, mounting: ca.SX, gravity: float, *, up: Vector3 = UP) -> ca.SX:
        """Return the specific force (3,), the paper off level; `up` is that of `level_rad`."""
        level = [told + more for told, more in zip(self.level_rad, self.by[LEVEL], strict=True)]
        leaning = rotation_matrix(ca.vertcat(*level, 0))[:, 2] - ca.DM(UP)
        place = mounting + ca.vertcat(*self.by[LEVER])
        force = self.rigid.specific_force(place, gravity)
        return self._turned(force + gravity * self.rigid.world_to_body @ leaning)

    def body_rate(self) -> ca.SX:
        """Return the body rate (3,)."""
        return self._turned(self.rigid.body_rate())

    def _turned(self, vector: ca.SX) -> ca.SX:
        return rotation_matrix(ca.vertcat(*self.by[TURN])).T @ vector
