"""The pen of [Pen]: coordinates of tip and Euler angles, with their rates.

    x = (q, q̇, q̈),   q = (X, Y, Z, φ, θ)

(X, Y, Z) is the tip, φ the azimuth and θ the elevation of the axis from tip to top. A chain
(`models.chains`) drives each coordinate; white jerk is the paper's.

White jerk on Euler angles is information: a gyroscope alone seems to show tilt, because a
constant error of θ changes what jerk the same body rate needs. That is true of a pen that cannot
spin. One that can is `models.free_pen`.

References
----------
[Pen] equations (1)-(3), with E1 corrected.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from models.arrays import Array
from models.body_model import Kinematics
from models.kinematics import RigidBody
from models.manifold import wrapped_angles
from models.motion import Motion
from models.pen_config import Prior
from models.rotation import world_to_body

_TIP = ("tip_x", "tip_y", "tip_z")
_ANGLES = ("azimuth", "elevation", "spin")


def kinematic_states(degrees_of_freedom: int) -> tuple[tuple[str, str], ...]:
    """Return (name, unit) of q, q̇, q̈ in the order of the state; six have the spin ψ in q."""
    angles = _ANGLES[: degrees_of_freedom - 3]
    table = (
        ("{}_m", "{}_rad", "m", "rad"),
        ("{}_velocity_m_s", "{}_rate_rad_s", "m/s", "rad/s"),
        ("{}_acceleration_m_s2", "{}_acceleration_rad_s2", "m/s²", "rad/s²"),
    )
    return tuple(
        (pattern.format(name), unit)
        for tip_pattern, angle_pattern, tip_unit, angle_unit in table
        for pattern, unit, names in (
            (tip_pattern, tip_unit, _TIP),
            (angle_pattern, angle_unit, angles),
        )
        for name in names
    )


def euler_body(q: ca.SX, q_dot: ca.SX, q_ddot: ca.SX, *, fixed_spin_rad: float = 0.0) -> RigidBody:
    """Return the body in symbols of its coordinates (5,) or (6,), their rates and accelerations."""
    spin = q[5] if q.numel() == 6 else ca.SX(fixed_spin_rad)
    return RigidBody(q, q_dot, q_ddot, q[:3], world_to_body(q[3], q[4], spin))


def euler_kinematics(
    q: ca.SX, q_dot: ca.SX, q_ddot: ca.SX, motion: Motion, prior: Prior, *, has_camera: bool = True
) -> Kinematics:
    """Return states and motion of a pen with Euler rates.

    Parameters
    ----------
    q, q_dot, q_ddot : symbols (5,); (6,) has a spin too, for comparison with the free pen
    has_camera : see `tip_std`
    """
    n_q = q.numel()
    names, units = zip(*kinematic_states(n_q), strict=True)
    is_angle = tuple(3 <= i < n_q for i in range(len(names)))
    tip, turning = motion.tip.built(), motion.attitude.built()
    centre = ca.DM([*motion.tip.centre_m, *np.zeros(2 * n_q + n_q - 3)])

    def step(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
        F, G = (
            _of_all([of_tip(dt)] * 3 + [of_angle(dt)] * (n_q - 3))
            for of_tip, of_angle in (
                (tip.transition, turning.transition),
                (tip.factor, turning.factor),
            )
        )
        return centre + (F @ (x - centre) + G @ w)

    mean, std = _prior(prior, tip_std(motion, prior, has_camera=has_camera), n_q)
    return Kinematics(
        x=ca.vertcat(q, q_dot, q_ddot),
        names=names,
        units=units,
        step=step,
        retract=lambda x, d: wrapped_angles(x + d, is_angle),
        difference=lambda to, of: wrapped_angles(to - of, is_angle),
        mean=mean,
        covariance=np.diag(np.square(std)),
        regularity=ca.cos(q[4]),
    )


def _of_all(parts: list[ca.SX]) -> ca.SX:
    """Return (3 n, 3 n): matrices (3, 3) of n coordinates, in blocks of position, rate, …"""
    return ca.vertcat(
        *(
            ca.horzcat(*(ca.diag(ca.vertcat(*(p[i, j] for p in parts))) for j in range(3)))
            for i in range(3)
        )
    )


def tip_std(motion: Motion, prior: Prior, *, has_camera: bool) -> tuple[float, float]:
    """Return standard deviations of the tip's first velocity and acceleration.

    The prior's, where a camera sees the pen. Where none does, they are those that the tip's
    chain keeps for ever, if it does: a start livelier than the motion would be felt as tilt.
    """
    stationary = motion.tip.built().stationary_std[1:]
    if has_camera or not np.isfinite(stationary).all():
        return prior.velocity_std_m_s, prior.acceleration_std_m_s2
    return stationary[0], stationary[1]


def _prior(prior: Prior, tip: tuple[float, float], n_q: int) -> tuple[Array, Array]:
    """Return mean and standard deviation (3 n_q,)."""
    n_angles = n_q - 3
    mean_angles = [prior.azimuth_rad, prior.elevation_rad, prior.spin_rad][:n_angles]
    std_angles = [prior.azimuth_std_rad, prior.elevation_std_rad, prior.spin_std_rad][:n_angles]
    std = np.array(
        [prior.tip_std_m] * 3
        + std_angles
        + [tip[0]] * 3
        + [prior.angle_rate_std_rad_s] * n_angles
        + [tip[1]] * 3
        + [prior.angle_acceleration_std_rad_s2] * n_angles
    )
    mean = np.zeros(len(std))
    mean[: 3 + n_angles] = [*prior.tip_m, *mean_angles]
    return mean, std
