"""Sums of c τ^k e^(-jτ), with exact derivative, product and integral.

What linear systems with a repeated pole are made of; coefficients stay as written until a
function is evaluated at a symbol.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.arrays import Array

SMALL = 0.1
"""Below this argument a function over a power of it is its power series: the formula would
lose digits."""
SERIES_TERMS = 12


@dataclass(frozen=True)
class PolyExp:
    """The function Σ c τ^k e^(-jτ).

    Parameters
    ----------
    terms : (k, j) → c, with k and j natural numbers
    """

    terms: Mapping[tuple[int, int], float]

    def __call__(self, tau: ca.SX) -> ca.SX:
        """Return the value at a symbol."""
        return sum((c * tau**k * ca.exp(-j * tau) for (k, j), c in self._used), ca.SX(0))

    def over_power(self, tau: ca.SX, n: int) -> ca.SX:
        """Return the value over τⁿ, finite at τ = 0, where it begins with τⁿ or higher."""
        if not n:
            return self(tau)
        if not any(j for (_, j), _ in self._used):
            return sum((c * tau ** (k - n) for (k, _), c in self._used), ca.SX(0))
        is_small = tau < SMALL
        series = ca.SX(0)
        for coefficient in self.series(n, SERIES_TERMS)[::-1]:
            series = series * tau + coefficient
        away = ca.if_else(is_small, SMALL, tau)
        return ca.if_else(is_small, series, self(away) / away**n)

    def series(self, n: int, terms: int) -> Array:
        """Return the first coefficients (terms,) of the power series of the value over τⁿ."""
        return np.array([self._taylor(power) for power in range(n, n + terms)])

    def derivative(self) -> PolyExp:
        """Return d/dτ."""
        found: dict[tuple[int, int], float] = defaultdict(float)
        for (k, j), c in self._used:
            if k:
                found[k - 1, j] += k * c
            if j:
                found[k, j] -= j * c
        return PolyExp(found)

    def integral(self, x: ca.SX) -> ca.SX:
        """Return ∫₀^x dτ; it loses digits where x is small."""
        total = ca.SX(0)
        for (k, j), c in self._used:
            if not j:
                total += c / (k + 1) * x ** (k + 1)
                continue
            partial = sum(((j * x) ** i / math.factorial(i) for i in range(k + 1)), ca.SX(0))
            total += c * math.factorial(k) / j ** (k + 1) * (1 - ca.exp(-j * x) * partial)
        return total

    def __add__(self, other: PolyExp) -> PolyExp:
        """Return the sum."""
        found = defaultdict(float, self.terms)
        for term, c in other.terms.items():
            found[term] += c
        return PolyExp(found)

    def __mul__(self, other: PolyExp) -> PolyExp:
        """Return the product."""
        found: dict[tuple[int, int], float] = defaultdict(float)
        for (k, j), c in self._used:
            for (m, n), d in other._used:
                found[k + m, j + n] += c * d
        return PolyExp(found)

    def __rmul__(self, factor: float) -> PolyExp:
        """Return a multiple."""
        return PolyExp({term: factor * c for term, c in self.terms.items()})

    @property
    def _used(self) -> list[tuple[tuple[int, int], float]]:
        return [(term, c) for term, c in self.terms.items() if c]

    def _taylor(self, power: int) -> float:
        """Return the coefficient of τ^power in the power series."""
        return sum(
            c * (-j) ** (power - k) / math.factorial(power - k)
            for (k, j), c in self._used
            if k <= power
        )
