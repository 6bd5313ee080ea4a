"""Motions of a rod that several tests use."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tests.references.gyro_free import Array, RodMotion, rod_motion

HALF_DISTANCE_M = 0.04
ATTITUDE = Rotation.from_euler("zyx", [0.3, -0.7, 0.2])


def times(step_s: float, duration_s: float = 2.0) -> Array:
    return np.arange(round(duration_s / step_s) + 1) * step_s


def gesture(step_s: float) -> RodMotion:
    """A rod that is turned to and fro about both its cross axes, and carried along."""
    return rod_motion(
        lambda t: np.array([0.0, 8 * np.sin(5 * t), 6 * np.sin(7 * t + 0.5) * np.tanh(5 * t)]),
        lambda t: np.array([2 * np.sin(3 * t), np.sin(6 * t), -0.5 * np.sin(4 * t)]),
        times(step_s),
        HALF_DISTANCE_M,
        ATTITUDE,
    )


def circling(step_s: float, duration_s: float = 1.0) -> tuple[Array, Array]:
    """Return rates (n, 3) of constant size whose direction turns, and their exact c (n, 3)."""
    t = times(step_s, duration_s)
    size, turn = 1.5, 6.0
    zero = np.zeros_like(t)
    rate = size * np.column_stack([zero, np.cos(turn * t), np.sin(turn * t)])
    derivative = size * turn * np.column_stack([zero, -np.sin(turn * t), np.cos(turn * t)])
    c = np.column_stack([-(rate**2).sum(axis=1), derivative[:, 2], -derivative[:, 1]])
    return rate, c


def order(errors: list[float]) -> Array:
    """Return the orders of convergence between errors at steps that halve."""
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
