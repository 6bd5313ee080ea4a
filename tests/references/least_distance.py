"""Least-distance programming: min ½‖u‖² s.t. G u ≥ h, by non-negative least squares.

The window of a linear model is one in the coordinates u = R (z - z*) of its free optimum z*,
R the triangle of its whitened Jacobian. Ends after finitely many steps; the rows that it then
holds, as equations, bring the last digits.

References
----------
Lawson, Hanson (1974), Solving least squares problems, chapter 23, algorithm LDP.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from tests.references.batch import BatchProblem

Array = NDArray[np.float64]


def least_distance(G: Array, h: Array) -> tuple[Array, Array]:
    """Return u and its multipliers; u = Gᵀ multipliers. There must be such a u."""
    if len(h) == 0:
        return np.zeros(G.shape[1]), np.zeros(0)
    E, f = np.vstack([G.T, h]), np.append(np.zeros(G.shape[1]), 1.0)
    y, distance = nnls(E, f, maxiter=100 * len(h))
    assert distance > 1e-10, "no u meets all rows"
    held = y > 0
    multipliers = np.zeros(len(h))
    multipliers[held] = np.linalg.solve(G[held] @ G[held].T, h[held])
    u = G.T @ multipliers
    assert (multipliers >= 0).all(), "a row pulls"
    assert (G @ u >= h - 1e-9).all(), "a row is broken"
    return u, multipliers


@dataclass(frozen=True)
class HeldWindow:
    """States (n, n_x), noises z, their cost, multipliers (n, n_c), free standard deviations."""

    states: Array
    z: Array
    cost: float
    multipliers: Array
    std: Array


def solve_held(
    problem: BatchProblem, C: Array, d: Array, demanded: NDArray[np.bool_]
) -> HeldWindow:
    """Minimise a linear window's cost under C x_k <= d, (n_c,), where demanded (n, n_c)."""
    free = problem.solve()
    R = np.linalg.qr(problem.jacobian(free.z), mode="r")
    rows = np.concatenate([C @ Tk for Tk in problem.slopes])[demanded.ravel()]
    slack = np.concatenate([d - C @ x for x in free.states])[demanded.ravel()]
    M = np.linalg.solve(R.T, rows.T).T
    length = np.linalg.norm(M, axis=1)
    u, multipliers = least_distance(-M / length[:, None], -slack / length)
    z = free.z + np.linalg.solve(R, u)
    held = np.zeros(demanded.shape)
    held[demanded] = multipliers / length
    states = problem.states(z)
    cost = 0.5 * float(np.sum(problem.residual(z) ** 2))
    return HeldWindow(states, z, cost, held, free.std)
