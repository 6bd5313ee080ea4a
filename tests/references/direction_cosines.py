"""The attitude of a body that turns at a known rate, by quaternions and matrix exponentials."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def attitudes(rate: Callable[[float], Array], time_s: Array, start: Array) -> Array:
    """Return C (n, 3, 3), world to body, of a rate (3,) over time in body axes."""

    def derivative(t: float, q: Array) -> Array:
        x, y, z, w = q
        p, r, s = rate(t)
        return 0.5 * np.array(
            [
                w * p + y * s - z * r,
                w * r + z * p - x * s,
                w * s + x * r - y * p,
                -x * p - y * r - z * s,
            ]
        )

    first = Rotation.from_matrix(start.T).as_quat()
    q = solve_ivp(derivative, (0, time_s[-1]), first, "DOP853", time_s, rtol=1e-13, atol=1e-13).y
    return np.asarray(Rotation.from_quat(q.T).inv().as_matrix())


def at_constant_rate(rate: Array, duration_s: float, start: Array) -> Array:
    """Return C (3, 3) after a time: exp(-[ω]× t) C."""
    x, y, z = rate
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(expm(-skew * duration_s) @ start)
