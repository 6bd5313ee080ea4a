"""The Kalman filter as textbooks have it, in NumPy: gain, Joseph form, missing rows deleted.

Särkkä (2013), Bayesian Filtering and Smoothing, Theorem 4.2; Bierman (1977)
for the Joseph form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Posterior:
    """Mean and covariance after an update, with the innovation of the rows that were there."""

    mean: Array
    covariance: Array
    rows: NDArray[np.intp]
    innovation: Array
    innovation_covariance: Array


def predict(mean: Array, covariance: Array, F: Array, Q: Array) -> tuple[Array, Array]:
    """x⁻ = F x, P⁻ = F P Fᵀ + Q."""
    return F @ mean, F @ covariance @ F.T + Q


def joseph(covariance: Array, K: Array, H: Array, R: Array) -> Array:
    """P⁺ = (I - K H) P⁻ (I - K H)ᵀ + K R Kᵀ."""
    remainder = np.eye(len(covariance)) - K @ H
    return remainder @ covariance @ remainder.T + K @ R @ K.T


def update(mean: Array, covariance: Array, y: Array, H: Array, R: Array) -> Posterior:
    """Condition on y = H x + noise; rows of y that are NaN are deleted beforehand."""
    rows = np.flatnonzero(~np.isnan(y))
    y, H, R = y[rows], H[rows], R[np.ix_(rows, rows)]
    S = H @ covariance @ H.T + R
    K = np.linalg.solve(S, H @ covariance).T
    innovation = y - H @ mean
    return Posterior(mean + K @ innovation, joseph(covariance, K, H, R), rows, innovation, S)


def iterated(
    mean: Array,
    covariance: Array,
    reading: Callable[[Array], tuple[Array, Array]],
    settled: float,
    most: int,
) -> Posterior:
    """Update linearised at its own posterior, from the same prior each time (Bell, Cathey 1993).

    Parameters
    ----------
    reading : takes x, returns the residual y - h(x) in units of its noise, and its H
    settled : deviations from the linearisation point that end it; the one before is returned
    most : updates
    """

    def linearised_at(x: Array) -> Posterior:
        residual, H = reading(x)
        found = update(mean - x, covariance, residual, H, np.eye(len(residual)))
        return replace(found, mean=x + found.mean)

    first = best = linearised_at(mean)
    for _ in range(most - 1):
        again = linearised_at(best.mean)
        std = np.sqrt(np.diag(best.covariance))
        if not (np.abs(again.mean - best.mean) / std).max() > settled:
            break
        best = again
    return Posterior(
        best.mean, best.covariance, first.rows, first.innovation, first.innovation_covariance
    )


def run(
    prior: tuple[Array, Array],
    times: Sequence[float],
    readings: Sequence[Array],
    F: Callable[[float], Array],
    Q: Callable[[float], Array],
    H: Array,
    R: Array,
) -> list[Posterior]:
    """Update, then predict to the next time: a posterior for each reading.

    Parameters
    ----------
    prior : mean and covariance at the first time
    F, Q : of a step of Δt
    """
    return run_varying(prior, times, readings, F, Q, H, [R] * len(readings))


def run_varying(
    prior: tuple[Array, Array],
    times: Sequence[float],
    readings: Sequence[Array],
    F: Callable[[float], Array],
    Q: Callable[[float], Array],
    H: Array,
    R: Sequence[Array],
) -> list[Posterior]:
    """Return the same where each reading has an R of its own."""
    x, P = prior
    posteriors: list[Posterior] = []
    for k, y in enumerate(readings):
        if k:
            dt = times[k] - times[k - 1]
            x, P = predict(x, P, F(dt), Q(dt))
        posteriors.append(update(x, P, y, H, R[k]))
        x, P = posteriors[-1].mean, posteriors[-1].covariance
    return posteriors
