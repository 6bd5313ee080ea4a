"""What sensors on the axis of a pen without spin read, written out by hand in NumPy.

Explicit formulas of equations.md, section 1 ("what rigid-body kinematics
says"), for the state x = (q, q̇, q̈), q = (X, Y, Z, φ, θ). All take states
(n, 15) and return (n, rows); complex steps pass through.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def world_to_body(states: Array) -> Array:
    """B (n, 3, 3), rows -e_θ, e_φ, e_r."""
    azimuth, elevation = states[:, 3], states[:, 4]
    sin_a, cos_a, sin_e, cos_e = (
        np.sin(azimuth),
        np.cos(azimuth),
        np.sin(elevation),
        np.cos(elevation),
    )
    zero = np.zeros_like(azimuth)
    x_b = np.stack([sin_e * cos_a, sin_e * sin_a, -cos_e], axis=1)
    y_b = np.stack([-sin_a, cos_a, zero], axis=1)
    z_b = np.stack([cos_e * cos_a, cos_e * sin_a, sin_e], axis=1)
    return np.stack([x_b, y_b, z_b], axis=1)


def accelerometer(states: Array, r: float, gravity: float = 9.81) -> Array:
    """Specific force at distance r from the tip: gravity + translation + rotation."""
    elevation, rate_a, rate_e = states[:, 4], states[:, 8], states[:, 9]
    acc_a, acc_e = states[:, 13], states[:, 14]
    sin_e, cos_e, zero = np.sin(elevation), np.cos(elevation), np.zeros_like(elevation)
    at_rest = np.stack([-gravity * cos_e, zero, gravity * sin_e], axis=1)
    translation = np.einsum("nij,nj->ni", world_to_body(states), states[:, 10:13])
    rotation = np.stack(
        [
            -r * acc_e - r * rate_a**2 * sin_e * cos_e,
            r * cos_e * acc_a - 2 * r * rate_a * rate_e * sin_e,
            -r * rate_e**2 - r * rate_a**2 * cos_e**2,
        ],
        axis=1,
    )
    return at_rest + translation + rotation


def gyroscope(states: Array) -> Array:
    """ω_b = (-cosθ ωφ, -ωθ, sinθ ωφ)."""
    elevation, rate_a, rate_e = states[:, 4], states[:, 8], states[:, 9]
    return np.stack([-np.cos(elevation) * rate_a, -rate_e, np.sin(elevation) * rate_a], axis=1)


def point_on_axis(states: Array, r: float) -> Array:
    """Tip + r e_r."""
    return states[:, :3] + r * world_to_body(states)[:, 2]


def camera(states: Array, r: float, target_to_body: Array) -> Array:
    """A pose camera's reading (n, 6): position and rotation vector, target to world."""
    body_to_world = np.swapaxes(world_to_body(states), 1, 2)
    turn = Rotation.from_matrix(body_to_world @ target_to_body).as_rotvec()
    return np.hstack([point_on_axis(states, r), turn])


def camera_residual(y: Array, states: Array, r: float, target_to_body: Array) -> Array:
    """(n, 5): position; the turn about body x and y from the predicted to the seen axis."""
    seen_axis = (Rotation.from_rotvec(y[:, 3:]).as_matrix() @ target_to_body.T)[:, :, 2]
    seen = np.einsum("nij,nj->ni", world_to_body(states), seen_axis)
    sine = np.sqrt(seen[:, 0] ** 2 + seen[:, 1] ** 2)
    angle_over_sine = np.arctan(sine / seen[:, 2]) / sine
    turn = np.stack([-seen[:, 1] * angle_over_sine, seen[:, 0] * angle_over_sine], axis=1)
    return np.hstack([y[:, :3] - point_on_axis(states, r), turn])
