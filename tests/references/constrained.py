"""A window with inequalities by SciPy's SLSQP, then exactly on the set it found active.

In the coordinates u = R (z - z*) of the unconstrained optimum z*, J = Q R, the
Hessian is nearly the identity, which SLSQP's quasi-Newton matrix starts from.
SLSQP still ends some digits early; Gauss-Newton steps with its active rows as
equations bring the rest. A row that is then broken is added, one with a
multiplier of the wrong sign let go, so what comes back meets the optimality
conditions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from tests.references.batch import BatchProblem

Array = NDArray[np.float64]

ACTIVE_SLACK_STD = 1e-5


@dataclass(frozen=True)
class ConstrainedSolution:
    """States (N+1, n_x), standard deviations without constraints, active rows (N+1, n_c)."""

    states: Array
    std: Array
    active: NDArray[np.bool_]
    cost: float


def solve_constrained(problem: BatchProblem, C: Array, d: Array) -> ConstrainedSolution:
    """Minimise the window's cost under C x_k <= d at every stage."""
    free = problem.solve()
    A = np.concatenate([C @ Tk for Tk in problem.slopes])
    b = np.concatenate([d - C @ x for x in problem.states(np.zeros(problem.n_z))])

    R = np.linalg.qr(problem.jacobian(free.z), mode="r")
    to_z = np.linalg.inv(R)
    M, slack = A @ to_z, b - A @ free.z
    length = np.linalg.norm(M, axis=1)
    M, slack = M / length[:, None], slack / length

    def cost(u: Array) -> float:
        return 0.5 * float(np.sum(problem.residual(free.z + to_z @ u) ** 2))

    def gradient(u: Array) -> Array:
        z = free.z + to_z @ u
        return to_z.T @ (problem.jacobian(z).T @ problem.residual(z))

    rows = {"type": "ineq", "fun": lambda u: slack - M @ u, "jac": lambda u: -M}
    start = np.zeros(problem.n_z)
    found = minimize(
        cost,
        start,
        jac=gradient,
        method="SLSQP",
        constraints=[rows],
        options={"ftol": 1e-15, "maxiter": 500},
    )
    active = slack - M @ found.x < ACTIVE_SLACK_STD
    z = free.z + to_z @ found.x
    for _ in range(10):
        z, multiplier = _polished(problem, z, A[active], b[active])
        held = np.zeros(len(b))
        held[active] = multiplier
        wrong = (b - A @ z < -1e-9 * length) | (held < -1e-9)
        if not wrong.any():
            break
        active = active ^ wrong
    assert not wrong.any(), "SLSQP's active set could not be mended"
    states = problem.states(z)
    return ConstrainedSolution(
        states, free.std, active.reshape(len(states), len(d)), problem.cost(states)
    )


def _polished(problem: BatchProblem, z: Array, A: Array, b: Array) -> tuple[Array, Array]:
    """Gauss-Newton on A z = b, until it stands still; also return the multipliers."""
    for _ in range(30):
        J, r = problem.jacobian(z), problem.residual(z)
        R = np.linalg.qr(J, mode="r")
        M = np.linalg.solve(R.T, A.T).T
        gradient = np.linalg.solve(R.T, J.T @ r)
        length = np.linalg.norm(M, axis=1)
        M, slack = M / length[:, None], (b - A @ z) / length
        step = -gradient + np.linalg.lstsq(M, slack + M @ gradient, rcond=None)[0]
        multiplier = np.linalg.lstsq(M.T, -gradient - step, rcond=None)[0]
        z = z + np.linalg.solve(R, step)
        if np.linalg.norm(step) < 1e-12:
            break
    assert np.linalg.norm(step) < 1e-9, "the polish did not settle"
    return z, multiplier
