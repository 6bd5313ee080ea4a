"""The error of an estimate as a tangent vector, however far an unseen symmetry has gone.

    e = (x ⊟ s(x̂, α)) + α ds/dα,     α the amount that leaves x ⊟ s(x̂, α) shortest

A symmetry s that no reading shows (a pen's heading) may be wrong by half a radian, and the rest
known to a milliradian relative to it. Along the plain x ⊟ x̂ the two mix to second order; along
the symmetry's own flow they do not. Where the error is small both are the same.
"""

from __future__ import annotations

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
    weight = 1 / model.prior.std
    for symmetry in model.symmetries:
        x, at, a = ca.SX.sym("x", model.n_x), ca.SX.sym("at", model.n_x), ca.SX.sym("a")
        away = model.difference(x, symmetry(at, a))
        scaled = ca.DM(weight) * away
        slope = ca.jacobian(scaled, a)
        step = -ca.dot(slope, scaled) / ca.sumsqr(slope)
        newton = ca.Function("newton", [x, at, a], [a + step])
        amount = np.zeros((1, len(states)))
        for _ in range(ITERATIONS):
            amount = newton(states.T, moved.T, amount).full()
        turn = ca.Function("turn", [at, a], [ca.densify(symmetry(at, a))])
        along += (amount * direction_function(model, symmetry)(moved.T).full()).T
        moved = turn(moved.T, amount).full().T
    errors: Array = np.asarray(model.difference(states.T, moved.T).full().T) + along
    return errors
