"""Values and standard deviations of what people read, from a state and its covariance.

    y = outputs(x),   J = ∂/∂δ outputs(retract(x, δ)) at δ = 0,   σ² = diag(J P Jᵀ)

P is the covariance of a tangent vector. An output that is one component of state and tangent
vector (the tip, a bias) is read there; the others are *derived*, and every step reports them.

An angle on the circle is never less known than one of which nothing is known, π/√3.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from models.arrays import Array
from models.outputs import UNIFORM_ANGLE_STD_RAD, Outputs
from models.state_space import StateSpaceModel

NAME = "derived"
"""Of the function that every loop calls, and of the block of values that it fills."""


@dataclass(frozen=True, eq=False)
class Derived:
    """The outputs of a model that are not its states.

    Parameters
    ----------
    names, units : (k,)
    function : (mean (n_x,), covariance (n_x, n_x)) -> values (k,), standard deviations (k,)
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    function: ca.Function

    def values(self, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """Return values and deviations (n, k) of states (n, n_x)."""
        n, k = len(mean), len(self.names)
        if not n or not k:
            return np.zeros((n, k)), np.zeros((n, k))
        # One call for all instants: CasADi takes a column, or a block of columns, for each.
        values, std = self.function(mean.T, covariance.reshape(-1, covariance.shape[-1]).T)
        return values.full().T, std.full().T


def outputs_of(model: StateSpaceModel) -> Outputs:
    """Return what people read of a model: its outputs, or its states."""
    if model.outputs is not None:
        return model.outputs
    x = ca.SX.sym("x", model.n_x)
    function = ca.Function("outputs", [x], [x], ["x"], ["outputs"])
    return Outputs(model.state_names, model.state_units, function, (False,) * model.n_x)


@lru_cache(maxsize=16)
def derived_outputs(model: StateSpaceModel) -> Derived:
    """Return the derived outputs of a model, none for one that is read by its states.

    Made once per model: layouts, loops, readers and headers all ask for them.
    """
    x, P = ca.SX.sym("x", model.n_x), ca.SX.sym("P", model.n_x, model.n_x)
    outputs = outputs_of(model)
    J = outputs.jacobian(model.retract, x)
    rows = [] if model.outputs is None else [i for i in range(J.shape[0]) if not _is_unit(J[i, :])]
    J = J[rows, :]
    std = ca.sqrt(ca.fmax(ca.sum2((J @ P) * J), 0))
    for i, row in enumerate(rows):
        if outputs.wrapped[row]:
            std[i] = ca.fmin(std[i], UNIFORM_ANGLE_STD_RAD)
    results = [ca.densify(outputs.function(x)[rows]), ca.densify(std)]
    return Derived(
        tuple(outputs.names[i] for i in rows),
        tuple(outputs.units[i] for i in rows),
        ca.Function(NAME, [x, P], results, ["x", "P"], ["values", "std"], {"cse": True}),
    )


@lru_cache(maxsize=16)
def output_jacobian(model: StateSpaceModel) -> ca.Function:
    """Return (x (n_x,)) -> J (n_o, n_x), rows of `outputs_of` along the tangent space."""
    x = ca.SX.sym("x", model.n_x)
    J = ca.SX.eye(model.n_x)
    if model.outputs is not None:
        J = model.outputs.jacobian(model.retract, x)
    return ca.Function("output_jacobian", [x], [ca.densify(J)], ["x"], ["J"])


def _is_unit(row: ca.SX) -> bool:
    """Whether a row has one entry, the constant 1."""
    entries = [row[j] for j in row.sparsity().get_col() if not row[j].is_zero()]
    return len(entries) == 1 and entries[0].is_one()
