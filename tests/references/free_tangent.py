"""A free pen's state a tangent vector away, and what people read of it, by SciPy's rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

SIGMA, V, A = slice(3, 6), slice(6, 9), slice(12, 15)


def heading_of(attitude: Rotation) -> Rotation:
    """The turn about the vertical N of R = N M, where M's axis is level: swing and twist.

    Within 11° of where the body's z axis points down, of R turned half about its x.
    """
    x, y, z, w = np.atleast_2d(attitude.as_quat()).T
    is_plain = w**2 + z**2 > 0.01
    twist = 2 * np.where(is_plain, np.arctan2(z, w), np.arctan2(y, x))
    turns = Rotation.from_rotvec(np.outer(twist, [0.0, 0.0, 1.0]))
    return turns[0] if attitude.single else turns


def turn_of(attitude: Rotation, d: Array) -> Rotation:
    """W = Rz(d₃) MRP(N (d₁, d₂, 0) / 4) of a tangent vector (3,)."""
    level = heading_of(attitude).apply([d[0], d[1], 0.0])
    return Rotation.from_euler("z", d[2]) * Rotation.from_mrp(np.ravel(level) / 4)


def tangent_of(attitude: Rotation, turn: Rotation) -> Array:
    """The tangent vector (3,) of a turn in the world."""
    *_, z, w = turn.as_quat(canonical=True)
    twist = Rotation.from_euler("z", 2 * np.arctan2(z, w))
    level = heading_of(attitude).inv().apply((twist.inv() * turn).as_mrp())
    return np.array([*(4 * np.ravel(level)[:2]), 2 * np.arctan2(z, w)])


def retracted(x: Array, d: Array) -> Array:
    """R⁺ = W R, v and a turned by W, then added; the rest added."""
    before = Rotation.from_mrp(x[SIGMA])
    turn, moved = turn_of(before, d[SIGMA]), x + d
    moved[SIGMA] = (turn * before).as_mrp()
    for part in (V, A):
        moved[part] = turn.apply(x[part]) + d[part]
    return moved


def attitude_outputs(x: Array) -> dict[str, float]:
    """Azimuth, elevation and spin of an attitude away from upright, and its quaternion, w ≥ 0."""
    attitude = Rotation.from_mrp(x[SIGMA])
    azimuth, lean, spin = attitude.as_euler("ZYZ")
    quaternion = attitude.as_quat(canonical=True, scalar_first=True)
    named = {"azimuth_rad": azimuth, "elevation_rad": np.pi / 2 - lean, "spin_rad": spin}
    named |= {f"attitude_{axis}": q for axis, q in zip("wxyz", quaternion, strict=True)}
    return {name: float(value) for name, value in named.items()}
