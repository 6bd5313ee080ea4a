"""The optimum of a linear window under Huber's loss, by SciPy on the loss itself.

    min  ½‖z₋₁‖² + Σ ρ_w(w_i) + Σ ρ(‖r_k,sensor‖),   r linear in the unit noises z

    ρ(a) = a² / 2 where a ≤ k,   k a - k² / 2 beyond

No reweighting: gradient and generalised Hessian of ρ go to a trust-region Newton method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from tests.references.batch import BatchProblem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RobustSolution:
    """States (N+1, n_x) and cost at the optimum, and which groups of rows lie beyond k."""

    states: Array
    cost: float
    beyond: NDArray[np.bool_]


def solve_robust(
    problem: BatchProblem, groups: Sequence[Array], thresholds: Sequence[float]
) -> RobustSolution:
    """Minimise the loss.

    Parameters
    ----------
    problem : a linear window; its residual is (z, readings), as `BatchProblem.residual`
    groups : rows of that residual that share a loss, each row in one group
    thresholds : k per group; inf is least squares
    """
    zero = np.zeros(problem.n_z)
    J, r_0 = problem.jacobian(zero), problem.residual(zero)
    # In the coordinates of the least-squares problem its Hessian is the identity.
    to_z = np.linalg.inv(np.linalg.qr(J, mode="r"))
    A = J @ to_z

    def parts(u: Array) -> tuple[float, Array, Array]:
        r, cost = r_0 + A @ u, 0.0
        gradient, hessian = np.zeros(len(u)), np.zeros((len(u), len(u)))
        for rows, k in zip(groups, thresholds, strict=True):
            e, B = r[rows], A[rows]
            a = float(np.linalg.norm(e))
            if a <= k:
                cost, slope, curvature = cost + a**2 / 2, e, np.eye(len(e))
            else:
                cost, slope = cost + k * a - k**2 / 2, k / a * e
                curvature = k / a * (np.eye(len(e)) - np.outer(e, e) / a**2)
            gradient += B.T @ slope
            hessian += B.T @ curvature @ B
        return cost, gradient, hessian

    found = minimize(
        lambda u: parts(u)[0],
        zero,
        jac=lambda u: parts(u)[1],
        hess=lambda u: parts(u)[2],
        method="trust-exact",
        options={"gtol": 1e-10, "maxiter": 2000},
    )
    assert np.linalg.norm(parts(found.x)[1]) < 1e-7, "the reference did not converge"
    r = r_0 + A @ found.x
    far = [np.linalg.norm(r[rows]) > k for rows, k in zip(groups, thresholds, strict=True)]
    return RobustSolution(problem.states(to_z @ found.x), float(found.fun), np.array(far))
