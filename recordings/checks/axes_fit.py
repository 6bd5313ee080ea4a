"""In which of the 48 ways a gyroscope's axes lie to those of an accelerometer.

For each signed permutation P, proper or not, gravity's turning is predicted with ω = P ω_read + b
(`recordings.checks.turns`), b found with it. The P of the smallest Huber cost is what the
recording says; how sure that is tells the cost of P = I, window by window.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import permutations, product

import numpy as np

from models.arrays import Array
from recordings.checks.turns import GravityTurns

BIAS_STD_RAD_S = np.radians(5.0)
"""Of a gyroscope's bias before it is known."""
LARGEST_BIAS_RAD_S = np.radians(10.0)
"""Per axis; a wrong way may not be explained by more."""
HUBER = 1.5
"""Residuals beyond so many of the scale lose weight."""
ROUNDS = 8
LEAST_SCALE = np.radians(0.2)
"""Of residuals of Δ: smaller ones are as good as none."""


def signed_permutations() -> Array:
    """Return the (48, 3, 3) matrices that permute axes and turn signs, the identity first."""
    found = [
        np.diag(signs)[list(order)]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    return np.array(found)


CANDIDATES = signed_permutations()


@dataclass(frozen=True, eq=False)
class AxesFit:
    """What the windows say of each candidate.

    Parameters
    ----------
    costs : (48, w) Huber costs, in units of the scale's square
    correlation : (48,) between Δ and what is predicted
    bias : (48, 3) b, rad/s
    factor : (48,) by which gravity turns faster than is predicted
    """

    costs: Array
    correlation: Array
    bias: Array
    factor: Array

    @cached_property
    def best(self) -> int:
        """Which of `CANDIDATES` costs least."""
        return int(np.argmin(self.costs.sum(axis=1)))

    def worse_by(self, one: int, other: int) -> float:
        """Return by how many standard errors of its windows one candidate costs more."""
        more = self.costs[one] - self.costs[other]
        spread = float(np.sqrt(2 * np.sum(more**2)))  # windows overlap by half
        return float(more.sum()) / spread if spread > 0 else 0.0

    def unexplained(self, one: int) -> float:
        """Return which part of gravity's turning a candidate leaves unexplained: 1 - ρ², or 1."""
        return 1 - max(float(self.correlation[one]), 0.0) ** 2

    def alike(self, at_most: float) -> list[int]:
        """Return the candidates that cost no more than the best, but for so many errors."""
        return [i for i in range(len(CANDIDATES)) if self.worse_by(i, self.best) <= at_most]


def fit_axes(turns: GravityTurns) -> AxesFit:
    """Return what windows, at least one, say of every candidate."""
    G, B = turns.by_axes, turns.by_bias
    predicted = np.einsum("wcj,kj->kwc", G, CANDIDATES.reshape(-1, 9))
    missing = turns.turned - predicted  # (48, w, 3)
    # A floor of the scale, so that windows without turning tell nothing.
    weight = np.ones(missing.shape[:2])
    bias = np.zeros((len(CANDIDATES), 3))
    scale = LEAST_SCALE
    for _ in range(ROUNDS):
        BtB = np.einsum("kw,wca,wcb->kab", weight, B, B, optimize=True)
        Bty = np.einsum("kw,wca,kwc->ka", weight, B, missing, optimize=True)
        prior = np.eye(3) * (scale / BIAS_STD_RAD_S) ** 2
        bias = np.linalg.solve(BtB + prior, Bty[..., None])[..., 0]
        bias = np.clip(bias, -LARGEST_BIAS_RAD_S, LARGEST_BIAS_RAD_S)
        residual = np.linalg.norm(missing - np.einsum("wca,ka->kwc", B, bias), axis=2)
        scale = max(LEAST_SCALE, float(np.median(residual, axis=1).min()))
        weight = 1 / np.maximum(residual / (HUBER * scale), 1.0)
    size = residual / scale
    costs = np.where(size <= HUBER, size**2 / 2, HUBER * size - HUBER**2 / 2)
    whole = predicted + np.einsum("wca,ka->kwc", B, bias)
    together = np.sum(weight * np.sum(turns.turned * whole, axis=2), axis=1)
    own = np.sum(weight * np.sum(turns.turned**2, axis=1), axis=1)
    its = np.sum(weight * np.sum(whole**2, axis=2), axis=1) + np.finfo(float).tiny
    return AxesFit(costs, together / np.sqrt(own * its), bias, together / its)
