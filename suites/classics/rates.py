"""What the problems of ``classics.toml`` do between two samples: their rates, in CasADi.

A rate is ẋ(x, w, figures) with the noise w held over a step; a problem whose noise is one per
step adds it behind the step instead.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca

Figures = Mapping[str, Any]
Rate = Callable[[ca.SX, Figures], ca.SX]


def two_a_to_b(x: ca.SX, given: Figures) -> ca.SX:
    """2 A → B in a closed vessel: partial pressures of A and B."""
    reaction = given["k"] * x[0] ** 2
    return ca.vertcat(-2 * reaction, reaction)


def a_b_c(x: ca.SX, given: Figures) -> ca.SX:
    """A ⇌ B + C and 2 B ⇌ C: concentrations."""
    first = given["k1"] * x[0] - given["km1"] * x[1] * x[2]
    second = given["k2"] * x[1] ** 2 - given["km2"] * x[2]
    return ca.vertcat(-first, first - 2 * second, first + second)


def van_der_pol(x: ca.SX, given: Figures) -> ca.SX:
    """The oscillator with its damping μ as a state."""
    return ca.vertcat(x[1], x[2] * (1 - x[0] ** 2) * x[1] - x[0], 0)


def at_rest(x: ca.SX, given: Figures) -> ca.SX:
    """Nothing but noise moves it."""
    return ca.SX.zeros(x.numel())
