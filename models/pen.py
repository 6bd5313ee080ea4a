"""The rigid-body pen with five or six degrees of freedom.

State, in blocks of the degrees of freedom q = (X, Y, Z, φ, θ[, ψ]):

    x = (q, q̇, q̈, biases)

with constant acceleration per degree of freedom, driven by white jerk.
(X, Y, Z) is the tip, φ the azimuth and θ the elevation of the axis from tip to
top, ψ the spin about it; with five degrees of freedom ψ is a constant.

References
----------
[Pen] equations (1)-(3), with E1 corrected; spin and biases are additions.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import casadi as ca
import numpy as np

from models.arrays import Array
from models.body_model import (
    Kinematics,
    body_model,
    check_rest,
    choose_sensors,
    linear_step,
    rest_of,
)
from models.heading import heading_symmetry
from models.kinematics import RigidBody
from models.manifold import wrapped_angles
from models.paper import above_paper
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen
from models.printed import PrintedBody
from models.process_noise import constant_acceleration, white_jerk_factor
from models.rotation import world_to_body
from models.sensor_kinds.reading import MovingBody
from models.sensor_kinds.writing_area import WritingArea
from models.state_space import StateSpaceModel

_TIP = ("tip_x", "tip_y", "tip_z")
_ANGLES = ("azimuth", "elevation", "spin")


def kinematic_states(degrees_of_freedom: int) -> tuple[tuple[str, str], ...]:
    """Return (name, unit) of q, q̇, q̈ in the order of the state."""
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


def moving_pen(config: PenConfig, q: ca.SX, q_dot: ca.SX, q_ddot: ca.SX) -> MovingBody:
    """Return the pen as a body in symbols of its degrees of freedom."""
    has_spin = config.degrees_of_freedom == 6
    spin = q[5] if has_spin else ca.SX(config.fixed_spin_rad)
    rigid = RigidBody(q, q_dot, q_ddot, q[:3], world_to_body(q[3], q[4], spin))
    body = PrintedBody(rigid, config.printed_errors) if config.printed_errors else rigid
    return MovingBody(body, config.gravity_m_s2, has_spin)


def pen_model(
    pen: AnyPen,
    sensors: Iterable[str] | None = None,
    *,
    writing_area: bool = True,
    rest: bool = True,
) -> StateSpaceModel:
    """Build the state-space model of a pen with some or all of its sensors.

    Parameters
    ----------
    pen : a pen, the name of a bundled one, or the path of a pen file
    sensors : names from the pen file, in the order to stack them; None takes all
    writing_area : adds the pen's writing area where none of the sensors sees a position;
        False takes the sensors as they are, so position and tilt may drift without bound

    rest : adds the pen's sensor of rest, where its file has one, to a gyroscope; False takes
        the sensors as they are, so a still pen gains false confidence

    Raises
    ------
    InputError
        If a sensor or a bound is unknown, or rest has no gyroscope; the message lists what is.
    """
    config = as_pen(pen)
    chosen = choose_sensors(config.sensors, sensors, f"pen {config.name}")
    if writing_area and not any(sensor.sees_position for sensor in chosen.values()):
        chosen |= _writing_area(config)
    if rest:
        chosen |= rest_of(config.sensors, chosen)
    check_rest(chosen, f"pen {config.name}")
    n_q = config.degrees_of_freedom
    q, q_dot, q_ddot = (ca.SX.sym(symbol, n_q) for symbol in ("q", "q_dot", "q_ddot"))
    body = moving_pen(config, q, q_dot, q_ddot)
    name = f"{config.name}, {n_q} degrees of freedom"
    model = body_model(name, _kinematics(config, q, q_dot, q_ddot), body, chosen)
    model = model.replace(
        symmetries=(heading_symmetry(n_q, model.n_x, centre_m=_centre(chosen.values())),),
        reach=np.array([config.reach_m] * 3 + [np.inf] * (model.n_x - 3)),
    )
    model = model.bounded(**config.bounds)
    return model if config.paper is None else above_paper(model, config.paper)


def _centre(sensors: Iterable[Any]) -> Array | None:
    """Return the centre (3,) of the writing area, None without one."""
    for sensor in sensors:
        if sensor.place_m is not None:
            return np.array(sensor.place_m)
    return None


def _writing_area(config: PenConfig) -> dict[str, Any]:
    """Return the pen's writing area by name, or one around its prior tip where it has none."""
    for name, sensor in config.sensors.items():
        if sensor.place_m is not None:
            return {name: sensor}
    name = "area"
    while name in config.sensors:
        name = f"writing_{name}"
    return {name: WritingArea(centre_m=config.prior.tip_m)}


def _kinematics(config: PenConfig, q: ca.SX, q_dot: ca.SX, q_ddot: ca.SX) -> Kinematics:
    """Constant acceleration per degree of freedom, driven by white jerk."""
    n_q, noise = config.degrees_of_freedom, config.process_noise
    names, units = zip(*kinematic_states(n_q), strict=True)
    densities = ca.diag(
        ca.DM(
            [noise.tip_jerk_density_m_s3_per_sqrt_hz] * 3
            + [noise.angle_jerk_density_rad_s3_per_sqrt_hz] * (n_q - 3)
        )
    )
    is_angle = tuple(3 <= i < n_q for i in range(len(names)))
    mean, std = _prior(config)
    return Kinematics(
        x=ca.vertcat(q, q_dot, q_ddot),
        names=names,
        units=units,
        step=linear_step(
            lambda dt: ca.kron(constant_acceleration(dt), ca.SX.eye(n_q)),
            lambda dt: ca.kron(white_jerk_factor(dt), densities),
        ),
        retract=lambda x, d: wrapped_angles(x + d, is_angle),
        difference=lambda to, of: wrapped_angles(to - of, is_angle),
        mean=mean,
        covariance=np.diag(np.square(std)),
        regularity=ca.cos(q[4]),
    )


def _prior(config: PenConfig) -> tuple[Array, Array]:
    """Return mean and standard deviation (3 n_q,) of the kinematic states."""
    prior, n_angles = config.prior, config.degrees_of_freedom - 3
    mean_angles = [prior.azimuth_rad, prior.elevation_rad, prior.spin_rad][:n_angles]
    std_angles = [prior.azimuth_std_rad, prior.elevation_std_rad, prior.spin_std_rad][:n_angles]
    std = np.array(
        [prior.tip_std_m] * 3
        + std_angles
        + [prior.velocity_std_m_s] * 3
        + [prior.angle_rate_std_rad_s] * n_angles
        + [prior.acceleration_std_m_s2] * 3
        + [prior.angle_acceleration_std_rad_s2] * n_angles
    )
    mean = np.zeros(len(std))
    mean[: 3 + n_angles] = [*prior.tip_m, *mean_angles]
    return mean, std
