"""A free pen's state a tangent vector away, and what people read of it, by SciPy's rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

TIP, SIGMA, V, A = slice(0, 3), slice(3, 6), slice(6, 9), slice(12, 15)


def retracted(x: Array, d: Array, pivot: Array) -> Array:
    """R⁺ = W R with W = MRP(d_θ / 4), p about the pivot, v and a turned by W, then added."""
    turn, moved = Rotation.from_mrp(d[SIGMA] / 4), x + d
    moved[SIGMA] = (turn * Rotation.from_mrp(x[SIGMA])).as_mrp()
    moved[TIP] = pivot + turn.apply(x[TIP] - pivot) + d[TIP]
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
