"""Bounds and inequalities of a model as rows g(x) ≤ 0, one list for every solver.

    g = (x_lower - x, x - x_upper, inequality(x))      finite bounds only

A row may be demanded only at instants that have some reading (`demanded`): a pen that
presses is on its paper.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.state_space import StateSpaceModel


@lru_cache(maxsize=16)
def constrain_function(model: StateSpaceModel) -> ca.Function:
    """Return x (n_x,) → (g (n_c,), C), all dense.

    C (n_x, n_c) holds the rows' derivatives along the tangent space, one per column.
    """
    x = ca.SX.sym("x", model.n_x)
    results = [ca.densify(value) for value in _rows(model, x)]
    return ca.Function("constrain", [x], results, ["x"], ["g", "C"], {"cse": True})


def slope_pattern(model: StateSpaceModel) -> ca.Sparsity:
    """Return which entries of C (n_x, n_c) can differ from zero."""
    _, C = _rows(model, ca.SX.sym("x", model.n_x))
    return C.sparsity()


def _rows(model: StateSpaceModel, x: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return g (n_c,) and C (n_x, n_c) at x."""
    delta = ca.SX.sym("delta", model.n_x)
    moved = model.retract(x, delta)
    below, above = np.isfinite(model.lower), np.isfinite(model.upper)
    g = ca.vertcat(
        ca.SX(0, 1),
        *(ca.DM(model.lower[i]) - moved[int(i)] for i in np.flatnonzero(below)),
        *(moved[int(i)] - ca.DM(model.upper[i]) for i in np.flatnonzero(above)),
        model.inequality(moved),
    )
    origin = ca.SX.zeros(model.n_x)
    C = ca.substitute(ca.jacobian(g, delta).T, delta, origin)
    return ca.substitute(g, delta, origin), C


def count(model: StateSpaceModel) -> int:
    """Return n_c, the number of rows."""
    bounds = np.isfinite(model.lower).sum() + np.isfinite(model.upper).sum()
    return int(bounds) + int(model.inequality.numel_out(0))


def needs(model: StateSpaceModel) -> NDArray[np.bool_]:
    """Return (n_c, n_y): which readings an instant must have for a row to be demanded."""
    of_bounds = np.zeros((count(model) - model.inequality.numel_out(0), model.n_y), dtype=bool)
    return np.vstack([of_bounds, model.inequality_needs])


def demanded(model: StateSpaceModel, y: Array) -> NDArray[np.bool_]:
    """Return which rows (n_c,) an instant with readings y (n_row,), NaN = missing, demands."""
    missing: NDArray[np.bool_] = needs(model) @ ~np.isfinite(y[: model.n_y])
    return ~missing


def inequality_demanded(model: StateSpaceModel, y: Array) -> NDArray[np.bool_]:
    """Return the last part of `demanded`: rows (n_g,) of the inequality, not of the bounds."""
    missing: NDArray[np.bool_] = model.inequality_needs @ ~np.isfinite(y[: model.n_y])
    return ~missing
