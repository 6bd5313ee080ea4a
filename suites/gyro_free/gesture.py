"""A gesture with its exact truth: a smooth rate in the body, a smooth path in the air.

The paper's own profile is lost; this one stands in for it. In its axes (x along the pen)

    (ωy, ωz) = A s(t) (cos α, sin α),   α = 2π ν t + α₀,   s = sin²(π t / T)
    p(t) = R (p_x(u), p_y(u), p_z(u)),  u(t) the minimum-jerk time law from 0 to 1 in T

with p a figure of eight that lifts a little, at rest at both ends. The direction of the
rate turns with ν, which the compensation lives on; ν = 0 keeps it in one plane. Amplitude,
turning, phases and size are drawn by seed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from scipy.integrate import solve_ivp

from models.arrays import Array
from models.random_streams import seed_sequence, stream

Roll = Literal["none", "no spin"]

SPREAD = (0.8, 1.2)
"""Range of the drawn factors of amplitude, turning and size."""

ELEVATION_RAD, ELEVATION_SPREAD_RAD = 0.6, 0.1
"""Of the pen's axis at the start: mean, and how far it is drawn from it at most."""

TRUTH_TOLERANCE = 1e-11


@dataclass(frozen=True)
class GestureConfig:
    """A gesture.

    Parameters
    ----------
    duration_s : T
    step_s : between samples
    rate_rad_s : A; larger makes the rate show in c_X, which goes with its square
    turns_hz : ν; larger makes the determinant of the compensation larger, 0 makes it vanish
    size_m : of the path
    roll : about the pen's axis: ``none``, ωx = 0 as the paper assumes, or what a pen rolls
        whose spin angle is constant, ωx = sinθ φ̇
    """

    duration_s: float = 2.0
    step_s: float = 0.005
    rate_rad_s: float = 1.5
    turns_hz: float = 1.0
    size_m: float = 0.1
    roll: Roll = "none"


@dataclass(frozen=True, eq=False)
class GestureMotion:
    """Truth of a gesture, in axes with x along the pen; SI.

    Parameters
    ----------
    time_s : (n,)
    rate, rate_derivative : (n, 3) in body axes. The derivative about x, which two
        accelerometers on the axis do not feel, is left zero
    C : (n, 3, 3) direction cosines, world to body
    acceleration, position : (n, 3) of the centre of mass over ground
    """

    time_s: Array
    rate: Array
    rate_derivative: Array
    C: Array
    acceleration: Array
    position: Array

    def first(self, duration_s: float) -> GestureMotion:
        """Return the begin of the gesture."""
        n = int(np.searchsorted(self.time_s, duration_s, side="right"))
        return GestureMotion(
            *(getattr(self, name)[:n] for name in self.__dataclass_fields__),
        )


@cache
def gesture(config: GestureConfig, seed: int) -> GestureMotion:
    """Return the gesture of a seed."""
    rng = stream(seed_sequence(seed), "gesture")
    amplitude, turning, size = rng.uniform(*SPREAD, 3)
    alpha0, heading = rng.uniform(-math.pi, math.pi, 2)
    elevation = ELEVATION_RAD + ELEVATION_SPREAD_RAD * rng.uniform(-1, 1)
    T, A = config.duration_s, amplitude * config.rate_rad_s
    alpha_dot = 2 * math.pi * turning * config.turns_hz
    time_s: Array = np.arange(round(T / config.step_s) + 1) * np.float64(config.step_s)

    def yz(t: Array | float) -> tuple[Array, Array]:
        """Return (ωy, ωz) and its derivative, each (2, …)."""
        s, s_dot = np.sin(np.pi * t / T) ** 2, np.pi / T * np.sin(2 * np.pi * t / T)
        if config.turns_hz:
            alpha = alpha_dot * t + alpha0
            e, e_dot = _unit(alpha), alpha_dot * _unit(alpha + np.pi / 2)
        else:  # one direction, to and fro
            swing = 2 * np.pi * turning * t
            e = _unit(alpha0 + 0 * t) * np.cos(swing)
            e_dot = _unit(alpha0 + 0 * t) * -np.sin(swing) * 2 * np.pi * turning
        return A * s * e, A * (s_dot * e + s * e_dot)

    def rate_of(t: float, C: Array) -> Array:
        wy, wz = yz(t)[0]
        # Without spin: sinθ φ̇, with φ̇ = -ωy / cosθ.
        roll = -wy * C[0, 2] / math.hypot(C[0, 0], C[0, 1]) if config.roll == "no spin" else 0.0
        return np.array([roll, wy, wz])

    def derivative(t: float, flat: Array) -> Array:
        C = flat.reshape(3, 3)
        return -np.cross(rate_of(t, C), C, axisb=0, axisc=0).ravel()

    C0 = start_cosines(elevation)
    solved = solve_ivp(
        derivative,
        (0.0, T),
        C0.ravel(),
        "DOP853",
        time_s,
        rtol=TRUTH_TOLERANCE,
        atol=TRUTH_TOLERANCE,
    )
    C = solved.y.T.reshape(-1, 3, 3)
    rate = np.array([rate_of(t, c) for t, c in zip(time_s, C, strict=True)])
    rate_derivative = np.column_stack([np.zeros(len(time_s)), yz(time_s)[1].T])
    acceleration, position = _path(time_s / T, T, size * config.size_m, heading)
    return GestureMotion(time_s, rate, rate_derivative, C, acceleration, position)


def start_cosines(elevation: float) -> Array:
    """Return C (3, 3) of a pen of azimuth 0 and spin 0: x up the pen, y down, z aside."""
    s, c = math.sin(elevation), math.cos(elevation)
    return np.array([[c, 0.0, s], [s, 0.0, -c], [0.0, 1.0, 0.0]])


def _unit(angle: Array | float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def _path(tau: Array, T: float, size: float, heading: float) -> tuple[Array, Array]:
    """Return acceleration and position (n, 3) of the figure of eight."""
    u = 10 * tau**3 - 15 * tau**4 + 6 * tau**5
    u_dot = (30 * tau**2 - 60 * tau**3 + 30 * tau**4) / T
    u_ddot = (60 * tau - 180 * tau**2 + 120 * tau**3) / T**2
    w = 2 * np.pi
    p = np.array([np.sin(w * u), np.sin(2 * w * u) / 2, (1 - np.cos(w * u)) / 5])
    first = w * np.array([np.cos(w * u), np.cos(2 * w * u), np.sin(w * u) / 5])
    second = w**2 * np.array([-np.sin(w * u), -2 * np.sin(2 * w * u), np.cos(w * u) / 5])
    cos, sin = math.cos(heading), math.sin(heading)
    turn = size * np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    return (turn @ (second * u_dot**2 + first * u_ddot)).T, (turn @ p).T
