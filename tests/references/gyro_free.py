"""A rod in the air and two accelerometers on it, from Newton's and Euler's equations.

Independent of the formulas under test: the body is moved by a torque and a force
(`scipy.integrate.solve_ivp`), and an accelerometer reads the second difference of its own
place in the world. The correction is the 2x2 system solved by `numpy.linalg`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

INERTIA = np.array([1e-7, 4e-5, 4e-5])
"""Of a rod about its axes, kg m²: equal across it, so that it does not start to roll."""

GRAVITY = 9.81
SECOND_DIFFERENCE_S = 2e-3


@dataclass(frozen=True, eq=False)
class RodMotion:
    """Times (n,), rates (n, 3), C (n, 3, 3), positions (n, 3), readings f1, f2 (n, 3)."""

    time_s: Array
    rate: Array
    C: Array
    position: Array
    f1: Array
    f2: Array


def rod_motion(
    angular_acceleration: Callable[[float], Array],
    acceleration: Callable[[float], Array],
    time_s: Array,
    half_distance_m: float,
    attitude: Rotation,
) -> RodMotion:
    """Move the rod from rest by a torque (per inertia, body axes) and a force (per mass)."""

    def derivative(t: float, state: Array) -> Array:
        quaternion, rate, velocity = state[:4], state[4:7], state[10:13]
        x, y, z, w = quaternion
        p, q, r = rate
        turning = 0.5 * np.array(
            [
                w * p + y * r - z * q,
                w * q + z * p - x * r,
                w * r + x * q - y * p,
                -x * p - y * q - z * r,
            ]
        )
        torque = INERTIA * angular_acceleration(t)
        rate_dot = (torque - np.cross(rate, INERTIA * rate)) / INERTIA
        return np.concatenate([turning, rate_dot, velocity, acceleration(t)])

    margin = 3 * SECOND_DIFFERENCE_S
    start = np.concatenate([attitude.as_quat(), np.zeros(9)])
    solved = solve_ivp(
        derivative,
        (0, time_s[-1] + margin),
        start,
        "DOP853",
        rtol=1e-13,
        atol=1e-13,
        dense_output=True,
    ).sol

    def place(t: Array, x: float) -> Array:
        states = solved(t).T
        # Before the start everything rests.
        return np.asarray(states[:, 7:10] + Rotation.from_quat(states[:, :4]).apply([x, 0.0, 0.0]))

    h = SECOND_DIFFERENCE_S
    C = Rotation.from_quat(solved(time_s)[:4].T).inv()
    forces = []
    for x in (-half_distance_m, half_distance_m):
        around = [place(np.maximum(time_s + k * h, 0.0), x) for k in (-2, -1, 0, 1, 2)]
        second = np.tensordot([-1 / 12, 4 / 3, -5 / 2, 4 / 3, -1 / 12], around, axes=1) / h**2
        forces.append(C.apply(second + np.array([0.0, 0.0, GRAVITY])))
    states = solved(time_s).T
    return RodMotion(time_s, states[:, 4:7], C.as_matrix(), states[:, 7:10], *forces)


def compensated_rate(
    c: Array,
    cx_dot: Array,
    step_s: float,
    start: tuple[float, float],
    least_determinant: float,
    greatest_condition: float,
    gain: float,
) -> tuple[Array, NDArray[np.bool_]]:
    """Integrate and correct, sample by sample, the matrix of (13)-(16) written out."""
    rates, applied = [np.array(start, dtype=float)], [False]
    for k in range(1, len(c)):
        mean = (c[k - 1] + c[k]) / 2
        w = rates[-1] + step_s * np.array([-mean[2], mean[1]])
        M = np.array([[2 * w[0], 2 * w[1]], [c[k, 2], -c[k, 1]]])
        b = np.array([w @ w + c[k, 0], w[0] * c[k, 2] - w[1] * c[k, 1] - cx_dot[k] / 2])
        apply = bool(
            np.isfinite(cx_dot[k])
            and abs(np.linalg.det(M)) >= least_determinant
            and np.linalg.cond(M) <= greatest_condition
        )
        if apply:
            w = w - gain * np.linalg.solve(M, b)
        rates.append(w)
        applied.append(apply)
    return np.array(rates), np.array(applied)
