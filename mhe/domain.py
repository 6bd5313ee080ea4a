"""A state stays where its model is defined: inside the bounds of the states that add.

Of a state that adds, x ⊞ δ is x + δ: clipping its component is then the nearest point inside.
Bounds of the others (angles that wrap, directions) are rows of `mhe.constraint_rows` only.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from models.arrays import Array
from models.state_space import StateSpaceModel


@lru_cache(maxsize=16)
def adding_states(model: StateSpaceModel) -> frozenset[int]:
    """Return the indices of states of which x ⊞ δ is x + δ."""
    x, delta = ca.SX.sym("x", model.n_x), ca.SX.sym("delta", model.n_x)
    moved = model.retract(x, delta)
    slopes = ca.jacobian(moved, delta)
    origin = ca.substitute(moved, delta, ca.SX.zeros(model.n_x))
    unit = ca.DM.eye(model.n_x)
    return frozenset(
        i
        for i in range(model.n_x)
        if ca.sparsify(slopes[i, :] - unit[i, :]).nnz() == 0 and ca.is_equal(origin[i], x[i], 2)
    )


@lru_cache(maxsize=16)
def limits(model: StateSpaceModel) -> tuple[Array, Array]:
    """Return lower and upper (n_x,): a model's bounds of the states that add, else infinite."""
    adding = np.isin(np.arange(model.n_x), list(adding_states(model)))
    return np.where(adding, model.lower, -np.inf), np.where(adding, model.upper, np.inf)


def inside(model: StateSpaceModel, x: Array) -> Array:
    """Return the nearest point (n_x,) of the domain."""
    lower, upper = limits(model)
    clipped: Array = np.clip(x, lower, upper)
    return clipped
