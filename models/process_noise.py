"""Continuous white noise, discretised exactly for any step.

White jerk of spectral density S per degree of freedom gives over a step Δt

    Q = S [[Δt⁵/20, Δt⁴/8, Δt³/6], [Δt⁴/8, Δt³/3, Δt²/2], [Δt³/6, Δt²/2, Δt]]
      = (√S D C)(√S D C)ᵀ,    D = √Δt diag(Δt², Δt, 1),

with C the Cholesky factor of the constant matrix in the middle. White acceleration is
the same chain without its last link, (position, velocity):

    Q = S [[Δt³/3, Δt²/2], [Δt²/2, Δt]] = (√S D C)(√S D C)ᵀ,    D = √Δt diag(Δt, 1).

No matrix is factorised at run time, and Δt = 0 is a step like any other.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

_UNIT_STEP_COVARIANCE = np.array([[1 / 20, 1 / 8, 1 / 6], [1 / 8, 1 / 3, 1 / 2], [1 / 6, 1 / 2, 1]])
UNIT_STEP_FACTOR = np.linalg.cholesky(_UNIT_STEP_COVARIANCE)
"""(3, 3) lower triangle C for (position, velocity, acceleration)."""

WHITE_ACCELERATION_UNIT_STEP_FACTOR = np.array([[1 / np.sqrt(3), 0], [np.sqrt(3) / 2, 1 / 2]])
"""(2, 2) lower triangle C for (position, velocity)."""


def white_jerk_factor(dt: ca.SX) -> ca.SX:
    """Return D C, the (3, 3) factor of Q for S = 1 and a step of `dt` seconds."""
    powers = ca.sqrt(dt) * ca.vertcat(dt**2, dt, 1)
    return ca.diag(powers) @ ca.sparsify(ca.DM(UNIT_STEP_FACTOR))


def constant_acceleration(dt: ca.SX) -> ca.SX:
    """Return the (3, 3) transition of (position, velocity, acceleration) over `dt`."""
    return ca.vertcat(ca.horzcat(1, dt, dt**2 / 2), ca.horzcat(0, 1, dt), ca.horzcat(0, 0, 1))


def white_acceleration_factor(dt: ca.SX) -> ca.SX:
    """Return D C, the (2, 2) factor of Q for S = 1 and a step of `dt` seconds."""
    powers = ca.sqrt(dt) * ca.vertcat(dt, 1)
    return ca.diag(powers) @ ca.sparsify(ca.DM(WHITE_ACCELERATION_UNIT_STEP_FACTOR))


def constant_velocity(dt: ca.SX) -> ca.SX:
    """Return the (2, 2) transition of (position, velocity) over `dt`."""
    return ca.vertcat(ca.horzcat(1, dt), ca.horzcat(0, 1))
