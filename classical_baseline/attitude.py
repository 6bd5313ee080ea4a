"""The attitude from the rate: direction cosines, integrated and kept orthonormal.

    Ċ = -[ω]× C,      C_{k+1} = Exp(-[ω̄]× Δt) C_k,   ω̄ = (ω_k + ω_{k+1}) / 2            (9)

C takes world to body coordinates. The step is exact for a constant rate and of second
order otherwise; it is a rotation to rounding, and what rounding adds up is taken off.

References
----------
[GyroFree] (9)-(10).
"""

from __future__ import annotations

import numpy as np

from models.arrays import Array
from models.errors import InputError

SMALL_ANGLE_RAD = 1e-6
"""Below it, sine and cosine of the formula are replaced by their limits."""

NOT_ORTHONORMAL = 1e-6
_IDENTITY = np.eye(3)


def direction_cosines(rate: Array, step_s: float, start: Array) -> Array:
    """Return C (n, 3, 3) of n samples.

    Parameters
    ----------
    rate : (n, 3) rad/s in body axes
    step_s : of even samples, s
    start : (3, 3) C at the first sample

    Raises
    ------
    InputError
        If the start is no rotation, or a shape disagrees.
    """
    if rate.ndim != 2 or rate.shape[1] != 3:
        raise InputError(f"rates have shape {rate.shape}, expected (n, 3)")
    if start.shape != (3, 3) or not _is_rotation(start):
        raise InputError("direction cosines at the start are no rotation, expected one")
    C = np.empty((len(rate), 3, 3))
    if len(rate):
        C[0] = start
    for k, turn in enumerate(_turns((rate[1:] + rate[:-1]) * (step_s / 2))):
        C[k + 1] = orthonormal(turn @ C[k])
    return C


def _is_rotation(C: Array) -> bool:
    away = np.abs(C @ C.T - _IDENTITY).max()
    return bool(away <= NOT_ORTHONORMAL and np.linalg.det(C) > 0)  # NaN is none either


def orthonormal(C: Array) -> Array:
    """Return the rotation next to a matrix (3, 3) that nearly is one.

    ``C (3 I - Cᵀ C) / 2``: one Newton step to the polar factor, which squares the error.
    """
    return np.asarray(C @ (1.5 * _IDENTITY - 0.5 * C.T @ C))


def _turns(angle: Array) -> Array:
    """Return Exp(-[angle]×) (n, 3, 3), changes of coordinates into axes turned by (n, 3)."""
    size = np.linalg.norm(angle, axis=1)[:, None, None]
    small = size < SMALL_ANGLE_RAD
    divisor = np.where(small, 1.0, size)
    sine = np.where(small, 1.0, np.sin(divisor) / divisor)
    cosine = np.where(small, 0.5, (1 - np.cos(divisor)) / divisor**2)
    skew = np.cross(angle[:, None, :], np.eye(3)).swapaxes(1, 2)
    return np.asarray(np.eye(3) - sine * skew + cosine * (skew @ skew))
