"""What the problems of ``classics.toml`` do between two samples: their rates, in CasADi.

A rate is ẋ(x, u, figures) without noise; a problem that has no known inputs has an empty u.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca

Figures = Mapping[str, Any]
Rate = Callable[[ca.SX, ca.SX, Figures], ca.SX]


def two_a_to_b(x: ca.SX, u: ca.SX, given: Figures) -> ca.SX:
    """2 A → B in a closed vessel: partial pressures of A and B."""
    reaction = given["k"] * x[0] ** 2
    return ca.vertcat(-2 * reaction, reaction)


def a_b_c(x: ca.SX, u: ca.SX, given: Figures) -> ca.SX:
    """A ⇌ B + C and 2 B ⇌ C: concentrations."""
    first = given["k1"] * x[0] - given["km1"] * x[1] * x[2]
    second = given["k2"] * x[1] ** 2 - given["km2"] * x[2]
    return ca.vertcat(-first, first - 2 * second, first + second)


def van_der_pol(x: ca.SX, u: ca.SX, given: Figures) -> ca.SX:
    """The oscillator with its damping μ as a state."""
    return ca.vertcat(x[1], x[2] * (1 - x[0] ** 2) * x[1] - x[0], 0)


def rotating_masses(x: ca.SX, u: ca.SX, given: Figures) -> ca.SX:
    """Three discs in a row between two motors, joined by springs; θ₁ is the last state.

    θ_i φ_i'' = c_i (φ_{i-1} - φ_i) - c_{i+1} (φ_i - φ_{i+1}) - d_i φ_i', motors at both ends
    """
    angles, rates, motors, theta_1 = x[:3], x[3:6], x[6:8], x[8]
    row = ca.vertcat(motors[0], angles, motors[1])
    inertias = (theta_1, given["theta_2_3"], given["theta_2_3"])
    torques = ca.DM(given["spring_c"]) * (row[1:] - row[:-1])
    accelerations = [
        (torques[i + 1] - torques[i] - given["damping_d"][i] * rates[i]) / inertias[i]
        for i in range(3)
    ]
    return ca.vertcat(rates, *accelerations, (u - motors) / given["motor_lag_s"], 0)


def pendulum_on_cart(x: ca.SX, u: ca.SX, given: Figures) -> ca.SX:
    """A point mass on a rod on a cart that a force pushes: x, θ (0 is upright), v, ω, length."""
    (cart, ball), g = given["masses_kg"], given["gravity_m_s2"]
    theta, v, omega, length = x[1], x[2], x[3], x[4]
    sin, cos = ca.sin(theta), ca.cos(theta)
    pull = ball * length * omega**2 * sin
    mass = cart + ball * sin**2
    return ca.vertcat(
        v,
        omega,
        (u - pull + ball * g * cos * sin) / mass,
        ((u - pull) * cos + (cart + ball) * g * sin) / (length * mass),
        0,
    )


def damped_spring(x: ca.SX, u: ca.SX, given: Figures) -> ca.SX:
    """A unit mass on a damped unit spring that a force pushes."""
    return ca.vertcat(x[1], -x[0] - 0.5 * x[1] + u)


def at_rest(x: ca.SX, u: ca.SX, given: Figures) -> ca.SX:
    """Nothing but noise moves it."""
    return ca.SX.zeros(x.numel())
