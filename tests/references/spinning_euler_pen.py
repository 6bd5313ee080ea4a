"""A pen that spins, on Euler angles and their rates: what a free pen was before it had body rates.

    x = (q, q̇, q̈, biases),   q = (X, Y, Z, φ, θ, ψ),   white jerk or a chain on each of q

It is for comparison only: its process noise charges for a constant error of θ or ψ, because that
changes which jerk of the angles the same body rate needs, so that every quick movement reads as
information on tilt and spin.
"""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.body_model import body_model, choose_sensors
from models.euler_pen import euler_body, euler_kinematics
from models.heading import heading_symmetry
from models.pen_config import PenConfig
from models.sensor_kinds.reading import MovingBody
from models.state_space import StateSpaceModel

Array = NDArray[np.float64]

N_Q = 6


def spinning_euler_pen(config: PenConfig, sensors: Iterable[str]) -> StateSpaceModel:
    """Build the model of a pen with some of its sensors, nothing added to them."""
    chosen = choose_sensors(config.sensors, sensors, f"pen {config.name}")
    q, q_dot, q_ddot = (ca.SX.sym(symbol, N_Q) for symbol in ("q", "q_dot", "q_ddot"))
    has_camera = any(sensor.sees_pose for sensor in chosen.values())
    kinematics = euler_kinematics(
        q, q_dot, q_ddot, config.motion, config.prior, has_camera=has_camera
    )
    body = MovingBody(euler_body(q, q_dot, q_ddot), config.gravity_m_s2, has_spin=True)
    model = body_model(f"{config.name}, Euler rates", kinematics, body, chosen)
    return model.replace(symmetries=(heading_symmetry(N_Q, model.n_x),))


def turns_of_angles(azimuth: Array, elevation: Array) -> Array:
    """Return (n, 3, 3), columns e_z, -e_φ, e_r: a turn in the world from (δφ, δθ, δψ)."""
    zero, one = np.zeros_like(azimuth), np.ones_like(azimuth)
    minus_e_phi = np.stack([np.sin(azimuth), -np.cos(azimuth), zero], axis=-1)
    e_r = np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=-1,
    )
    return np.stack([np.stack([zero, zero, one], axis=-1), minus_e_phi, e_r], axis=-1)
