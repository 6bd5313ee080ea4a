"""The differential solution: what the difference of two accelerometers says of the rotation.

They sit on the long axis, x in this system, at L₁ = (-l, 0, 0) and L₂ = (+l, 0, 0) from
the centre of mass:

    f_i = C (a - g_vec) + ω̇ × L_i + ω × (ω × L_i)                                   (5)-(6)
    c = (f₂ - f₁) / 2l = (-(ωy² + ωz²),  ω̇z + ωx ωy,  -ω̇y + ωx ωz)                    (11)
    (f₁ + f₂) / 2 = C (a - g_vec)                                                   (7)-(8)

References
----------
[GyroFree]; (11) re-derived.
"""

from __future__ import annotations

import math

import numpy as np

from models.arrays import Array
from models.errors import InputError


def differential_solution(f1: Array, f2: Array, half_distance_m: float) -> Array:
    """Return c (n, 3) in rad/s², equation (11).

    Parameters
    ----------
    f1, f2 : (n, 3) specific forces at -l and at +l on the x axis, m/s²
    half_distance_m : l; larger divides the sensors' errors by more

    Raises
    ------
    InputError
        If the distance is not positive.
    """
    _check(f1, f2)
    if not 0 < half_distance_m < math.inf:
        raise InputError(f"half distance is {half_distance_m} m, expected a positive length")
    return np.asarray((f2 - f1) / (2 * half_distance_m))


def angular_acceleration_without_roll(c: Array) -> Array:
    """Return ω̇ = (0, -c_Z, c_Y) (n, 3), rad/s², equation (12): ωx is taken for zero."""
    return np.column_stack([np.zeros(len(c)), -c[:, 2], c[:, 1]])


def centre_specific_force(f1: Array, f2: Array) -> Array:
    """Return the specific force (n, 3) at the centre of mass, m/s², equations (7)-(8)."""
    _check(f1, f2)
    return np.asarray((f1 + f2) / 2)


def _check(f1: Array, f2: Array) -> None:
    if f1.shape != f2.shape or f1.ndim != 2 or f1.shape[1] != 3:
        raise InputError(
            f"readings of the two accelerometers have shapes {f1.shape} and {f2.shape}, "
            "expected (n, 3) twice"
        )
