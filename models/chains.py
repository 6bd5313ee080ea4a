"""How one coordinate moves: three integrators in a row, driven by white noise.

    d/dt (p, v, a) = A (p, v, a) + e₃ √S w,     last row of A: -(c₀, c₁, c₂)

Over a step Δt, with the impulse response φ = (g, g′, g″) of A from its last state,

    F = [φ″ + c₂ φ′ + c₁ φ,  φ′ + c₂ φ,  φ](Δt),     Q = S ∫₀^Δt φ φᵀ ds = (√S G)(√S G)ᵀ

exactly, for any Δt: a step may be split at will, and Δt = 0 is a step like any other. With
x = λΔt and D = diag(Δt², Δt, 1) the response is φ = D φ̂, finite at x = 0, and

    G = √Δt D chol M(x),     M(x) = ∫₀¹ φ̂ φ̂ᵀ du

A chain is its g, in τ = λs; F and M are derived from it.

References
----------
Hartikainen, Särkkä (2010), Kalman filtering and smoothing solutions to temporal Gaussian process
regression models, MLSP: Matérn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from models.poly_exp import PolyExp
from models.process_noise import constant_acceleration, white_jerk_factor

SERIES_TERMS = 24
LARGEST_BY_SERIES = 1.0
"""λΔt up to which a power series gives M to rounding; beyond it the closed form does."""


@dataclass(frozen=True)
class Chain:
    """A driven chain of three integrators.

    Parameters
    ----------
    g : impulse response of p times λ², over τ = λs
    last_row : (c₀, c₁, c₂) for λ = 1
    rate : λ, 1/s; larger forgets sooner. 0 where g is a polynomial: white jerk
    density : √S, unit of the jerk per √Hz; larger follows faster motions and smooths less
    stationary_std : of (p, v, a) after a long time, infinite where nothing bounds them

    Rate and density may be symbols, see `pen_mhe.tuning.levels`.
    """

    g: PolyExp
    last_row: tuple[float, float, float]
    rate: float
    density: float
    stationary_std: tuple[float, float, float]

    def transition(self, dt: ca.SX) -> ca.SX:
        """Return F (3, 3) over `dt` seconds."""
        if not any(self.last_row):
            return constant_acceleration(dt)
        x, (_, c1, c2) = self.rate * dt, self.last_row
        third = _response(self.g)
        second = [f.derivative() + c2 * f for f in third]
        first = [f.derivative().derivative() + c2 * f.derivative() + c1 * f for f in third]
        F = ca.SX(3, 3)
        for j, column in enumerate((first, second, third)):
            for i, entry in enumerate(column):
                order = j - i  # of Δt in the entry
                F[i, j] = (
                    dt**order * entry.over_power(x, order)
                    if order > 0
                    else self.rate**-order * entry(x)
                )
        return ca.sparsify(F)

    def factor(self, dt: ca.SX) -> ca.SX:
        """Return √S G (3, 3), a lower triangle with Q = (√S G)(√S G)ᵀ, over `dt` seconds."""
        if not any(self.last_row):
            return white_jerk_factor(dt) * self.density
        M = _moments(tuple(self.g.terms.items()))(self.rate * dt)
        powers = ca.sqrt(dt) * ca.vertcat(dt**2, dt, 1)
        return ca.diag(powers) @ ca.chol(M).T * self.density


Response = tuple[PolyExp, PolyExp, PolyExp]


def _response(g: PolyExp) -> Response:
    """φ, its entries times λ², λ and 1."""
    slope = g.derivative()
    return g, slope, slope.derivative()


@cache
def _moments(terms: tuple[tuple[tuple[int, int], float], ...]) -> ca.Function:
    """Return x → M of the g of these terms: built once, it is most of what a model takes."""
    response, x = _response(PolyExp(dict(terms))), ca.SX.sym("x")
    is_small = x <= LARGEST_BY_SERIES
    # Both branches are evaluated: each gets an argument that it is good for.
    near = _by_series(response, ca.if_else(is_small, x, LARGEST_BY_SERIES))
    far = _closed_form(response, ca.if_else(is_small, LARGEST_BY_SERIES, x))
    return ca.Function("moments", [x], [ca.if_else(is_small, near, far)])


def _by_series(response: Response, x: ca.SX) -> ca.SX:
    """Return M of small x: the power series of ∫₀¹ u^(n+m) f_n(xu) f_m(xu) du."""
    M, orders = ca.SX(3, 3), (2, 1, 0)
    scaled = [f.series(n, SERIES_TERMS) for f, n in zip(response, orders, strict=True)]
    for i in range(3):
        for j in range(i + 1):
            powers = np.convolve(scaled[i], scaled[j])[:SERIES_TERMS]
            powers = powers / (np.arange(SERIES_TERMS) + orders[i] + orders[j] + 1)
            entry = ca.SX(0)
            for coefficient in powers[::-1]:
                entry = entry * x + coefficient
            M[i, j] = M[j, i] = entry
    return M


def _closed_form(response: Response, x: ca.SX) -> ca.SX:
    M = ca.SX(3, 3)
    for i in range(3):
        for j in range(i + 1):
            integral = (response[i] * response[j]).integral(x)
            M[i, j] = M[j, i] = integral / x ** (5 - i - j)
    return M


def white_jerk(density: float) -> Chain:
    """Return the chain that only its noise drives: nothing stays bounded.

    Parameters
    ----------
    density : √S, unit of the jerk per √Hz
    """
    g = PolyExp({(2, 0): 0.5})
    return Chain(g, (0.0, 0.0, 0.0), 0.0, density, (math.inf, math.inf, math.inf))


def bounded_velocity(speed_std: float, correlation_time_s: float) -> Chain:
    """Return the chain whose velocity forgets: it neither accelerates for ever nor gets fast.

    Parameters
    ----------
    speed_std : σ_v, of the velocity after a long time; larger follows faster motions
    correlation_time_s : 1/λ; larger is smoother and keeps a velocity longer
    """
    rate = 1 / correlation_time_s
    return Chain(
        PolyExp({(0, 0): 1.0, (0, 1): -1.0, (1, 1): -1.0}),
        (0.0, 1.0, 2.0),
        rate,
        2 * rate * ca.sqrt(rate) * speed_std,
        (math.inf, speed_std, rate * speed_std),
    )


def matern(std: float, correlation_time_s: float) -> Chain:
    """Return the chain whose place stays near zero: a Matérn 5/2 process.

    Parameters
    ----------
    std : of the place after a long time
    correlation_time_s : 1/λ; larger is smoother and stays away longer
    """
    rate = 1 / correlation_time_s
    return Chain(
        PolyExp({(2, 1): 0.5}),
        (1.0, 3.0, 3.0),
        rate,
        math.sqrt(16 / 3) * std * rate**2.5,
        (std, std * rate / math.sqrt(3), std * rate**2),
    )
