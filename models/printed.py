"""The pen as [Pen] prints it, signs and all, and what it says beside the rigid body.

    x = (q, q̇, q̈),   q = (X, Y, Z, φ, θ)                                           (1)
    x_k = A x_{k-1} + v_{k-1},   A = [[I, I Δt, I Δt²/2], [0, I, I Δt], [0, 0, I]]   (2), (3)
    z = (a_s + a_t + a_r, ωx, ωy) + n                                               (9)

The first part of this file is the paper, misprints included; nothing estimates
with it. The second reads it for comparison: with the axis signs `ACCELEROMETER_SIGNS`
and `GYROSCOPE_SIGNS` it agrees with the rigid body at rest, and what remains is

    E2  a_t has B_r⁻¹ where the rigid body has B_r (and, with the signs, the z axis that
        (4) points to the tip: what (5) adds is S B_r⁻¹ a, not B_r a)
    E3  the x axis of a_r has the sign opposite to that of a_s
    E4  the y axis of a_r lacks the Coriolis term

A sign belongs to an axis of the sensor, so it goes before (4), (5) and (6) alike.
A pen file may ask for any of the three (``printed_errors``); default is none.

References
----------
[Pen] equations (1)-(9).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, get_args

import casadi as ca

from models.kinematics import RigidBody
from models.level import UP, Vector3
from models.rotation import world_to_body
from models.sensor_kinds.mounted import IDENTITY

PrintedError = Literal["E2", "E3", "E4"]
PRINTED_ERRORS: tuple[PrintedError, ...] = get_args(PrintedError)
"""The errors of the printed accelerometer that no mounting explains."""

PRINTED_BLOCK = 3
"""Size of I in (3) as printed; the state (1) has blocks of five (E1)."""

ACCELEROMETER_SIGNS = (1, 1, -1)
GYROSCOPE_SIGNS = (-1, -1)
"""Axis signs with which the printed sensors agree with the rigid body at rest."""


def transition(dt: ca.SX, block: int = PRINTED_BLOCK) -> ca.SX:
    """Return A of (3), (3 block, 3 block), for a step of `dt` seconds.

    Parameters
    ----------
    block : size of I, 3 as printed
    """
    I, O = ca.SX.eye(block), ca.SX(block, block)  # noqa: E741
    return ca.vertcat(
        ca.horzcat(I, I * dt, I * dt**2 / 2),
        ca.horzcat(O, I, I * dt),
        ca.horzcat(O, O, I),
    )


def next_state(x: ca.SX, v: ca.SX, dt: ca.SX, *, block: int = PRINTED_BLOCK) -> ca.SX:
    """Return x_k of (2) from x_{k-1} and v_{k-1}, all (3 block,)."""
    return transition(dt, block) @ x + v


def rotation(q: ca.SX) -> ca.SX:
    """Return B_r (3, 3) of (7) for q = (X, Y, Z, φ, θ)."""
    return world_to_body(q[3], q[4], 0.0)


def gravity_part(q: ca.SX, gravity: float) -> ca.SX:
    """Return a_s (3,) of (4), m/s²: (-g cosθ, 0, -g sinθ)."""
    theta = q[4]
    return ca.vertcat(-gravity * ca.cos(theta), 0, -gravity * ca.sin(theta))


def translation_part(q: ca.SX, q_ddot: ca.SX) -> ca.SX:
    """Return a_t (3,) of (5), m/s²: B_r⁻¹ (ax, ay, az)."""
    inverse = rotation(q).T  # B_r is a rotation
    return inverse @ q_ddot[:3]


def rotation_part(q: ca.SX, q_dot: ca.SX, q_ddot: ca.SX, r: ca.SX | float) -> ca.SX:
    """Return a_r (3,) of (6), m/s², at a distance r (m) from the tip.

    ``(r ω̇θ + r cosθ ωφ² sinθ,  r cosθ ω̇φ,  r ωθ² + r cosθ ωφ² cosθ)``
    """
    theta = q[4]
    rate_phi, rate_theta = q_dot[3], q_dot[4]
    rate_phi_dot, rate_theta_dot = q_ddot[3], q_ddot[4]
    return ca.vertcat(
        r * rate_theta_dot + r * ca.cos(theta) * rate_phi**2 * ca.sin(theta),
        r * ca.cos(theta) * rate_phi_dot,
        r * rate_theta**2 + r * ca.cos(theta) * rate_phi**2 * ca.cos(theta),
    )


def body_rate(q: ca.SX, q_dot: ca.SX) -> ca.SX:
    """Return (ωx, ωy) (2,) of (8), rad/s: (cosθ ωφ, ωθ)."""
    return ca.vertcat(ca.cos(q[4]) * q_dot[3], q_dot[4])


def observation(q: ca.SX, q_dot: ca.SX, q_ddot: ca.SX, r: ca.SX | float, gravity: float) -> ca.SX:
    """Return z (5,) of (9) without noise: a_s + a_t + a_r, m/s², and (ωx, ωy), rad/s."""
    acceleration = (
        gravity_part(q, gravity) + translation_part(q, q_ddot) + rotation_part(q, q_dot, q_ddot, r)
    )
    return ca.vertcat(acceleration, body_rate(q, q_dot))


def error_terms(rigid: RigidBody, r: ca.SX | float) -> Mapping[PrintedError, ca.SX]:
    """Return what each error adds to a reading on the axis (3,), body axes, m/s².

    Printed minus rigid body, the printed terms along `ACCELEROMETER_SIGNS`.
    What the three leave out vanishes: gravity, and the z axis of a_r (E5).

    Parameters
    ----------
    rigid : a body whose q is (X, Y, Z, φ, θ), without spin
    r : distance from the tip, m
    """
    q, q_dot, q_ddot = rigid.q, rigid.q_dot, rigid.q_ddot
    signs = ca.DM(ACCELEROMETER_SIGNS)
    translation = rigid.specific_force(ca.SX.zeros(3), gravity=0.0)
    turning = rigid.specific_force(ca.vertcat(0, 0, r), gravity=0.0) - translation
    in_translation = signs * translation_part(q, q_ddot) - translation
    in_turning = signs * rotation_part(q, q_dot, q_ddot, r) - turning
    return {
        "E2": in_translation,
        "E3": ca.vertcat(in_turning[0], 0, 0),
        "E4": ca.vertcat(0, in_turning[1], 0),
    }


@dataclass(frozen=True)
class PrintedBody:
    """A rigid body whose accelerometers on the axis make errors of the paper.

    A `models.kinematics.Body`. Its gyroscopes are the rigid body's: (8) along
    `GYROSCOPE_SIGNS` is the rigid body's rate about x and y.

    Parameters
    ----------
    rigid : the true body, see `error_terms`
    errors : the errors to make
    """

    rigid: RigidBody
    errors: tuple[PrintedError, ...]

    @property
    def tip(self) -> ca.SX:
        """World position (3,) of the tip, m."""
        return self.rigid.tip

    @property
    def tip_velocity(self) -> ca.SX:
        """World velocity (3,) of the tip, m/s."""
        return self.rigid.tip_velocity

    @property
    def world_to_body(self) -> ca.SX:
        """The rotation matrix B (3, 3)."""
        return self.rigid.world_to_body

    def point(self, mounting: ca.SX) -> ca.SX:
        """Return the world position (3,) of a point given in body coordinates, m."""
        return self.rigid.point(mounting)

    def specific_force(self, mounting: ca.SX, gravity: float, *, up: Vector3 = UP) -> ca.SX:
        """Return what an accelerometer at `mounting` = (0, 0, r) reads with the errors, m/s²."""
        terms = error_terms(self.rigid, mounting[2])
        force = self.rigid.specific_force(mounting, gravity, up=up)
        return force + sum((terms[error] for error in self.errors), ca.SX.zeros(3))

    def body_rate(self) -> ca.SX:
        """Return the angular rate in body axes (3,), rad/s."""
        return self.rigid.body_rate()


def check_printed_pen(
    errors: tuple[PrintedError, ...],
    degrees_of_freedom: int = 5,
    *,
    fixed_spin_rad: float = 0.0,
    sensors: Mapping[str, Any] = MappingProxyType({}),
    **_: Any,
) -> None:
    """Raise `ValueError` where a pen cannot make errors of the paper.

    Parameters
    ----------
    errors : those that it is to make
    degrees_of_freedom, fixed_spin_rad, sensors : fields of `models.pen_config.PenConfig`
    """
    if len(set(errors)) < len(errors):
        raise ValueError(f"expected each error once, got {', '.join(errors)}")
    if errors and (degrees_of_freedom != 5 or fixed_spin_rad != 0):
        raise ValueError(
            "expected degrees_of_freedom = 5 and fixed_spin_rad = 0, the printed pen does not spin"
        )
    for name, sensor in sensors.items() if errors else ():
        if sensor.feels_gravity and (
            any(sensor.position_m[:2]) or sensor.sensor_to_body != IDENTITY
        ):
            raise ValueError(
                f"expected accelerometer {name} at position (0, 0, r) with the identity as "
                "sensor_to_body, the printed pen knows no other mounting"
            )
