"""The error of an estimate as a tangent vector, however far an unseen symmetry has gone.

    e = (x ⊟ s(x̂, α)) + α ds/dα,     α the amount that leaves x ⊟ s(x̂, α) shortest

A symmetry s that no reading shows (a pen's heading) may be wrong by half a radian, and the rest
known to a milliradian relative to it. Along the plain x ⊟ x̂ the two mix to second order; along
the symmetry's own flow they do not. Where the error is small both are the same.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from estimation.symmetry import direction_function
from models.arrays import Array
from models.state_space import StateSpaceModel

ITERATIONS = 8
"""Of Gauss-Newton in one variable: angles of two radians end at rounding."""


def true_errors(model: StateSpaceModel, estimates: Array, states: Array) -> Array:
    """Return errors (n, n_x) of estimates (n, n_x) from true states (n, n_x), truth minus estimate.

    Rows of states with NaN are NaN.
    """
    moved, along = estimates, np.zeros_like(estimates)
    for symmetry in model.symmetries:
        newton, turn = _functions(model, symmetry)
        amount = np.zeros((1, len(states)))
        for _ in range(ITERATIONS):
            amount = newton(states.T, moved.T, amount).full()
        along += (amount * direction_function(model, symmetry)(moved.T).full()).T
        moved = turn(moved.T, amount).full().T
    errors: Array = np.asarray(model.difference(states.T, moved.T).full().T) + along
    return errors


@lru_cache(maxsize=16)
def _functions(model: StateSpaceModel, symmetry: ca.Function) -> tuple[ca.Function, ca.Function]:
    """Return (x, at, a) → a after a step towards x of `at` turned by it; (at, a) → at turned."""
    x, at, a = ca.SX.sym("x", model.n_x), ca.SX.sym("at", model.n_x), ca.SX.sym("a")
    scaled = ca.DM(1 / model.prior.std) * model.difference(x, symmetry(at, a))
    slope = ca.jacobian(scaled, a)
    step = -ca.dot(slope, scaled) / ca.sumsqr(slope)
    return (
        ca.Function("newton", [x, at, a], [a + step]),
        ca.Function("turn", [at, a], [ca.densify(symmetry(at, a))]),
    )
