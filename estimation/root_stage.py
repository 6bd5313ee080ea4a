"""The Kalman stage in square roots, estimation/root_stage.c, for a loop in C.

    P = S Sᵀ,   [F S⁺, G D] Q = [S⁻, 0],   [[R^½, H S⁻], [0, S⁻]] Q = [[L, 0], [W, S⁺]]

with Q orthogonal and diagonals positive: the same L, W and e as of `estimation.kalman_stage`. In
single precision P⁻ - W Wᵀ soon is no covariance any more; S Sᵀ always is one. What is
generated is the linearisation only, derived from the covariance form's functions.

References
----------
Kailath, Sayed, Hassibi (2000), Linear Estimation, chapter 12, for the array form.
Golub, Van Loan (2013), Matrix Computations, section 5.1, for the reflections.
Carlson (1973), Fast triangular formulation of the square root filter, AIAA J. 11(9), for the
order of the rotations.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from estimation.loop import Loop
from models.arrays import Array
from models.state_space import StateSpaceModel


def transition_function(model: StateSpaceModel, predict: ca.Function) -> ca.Function:
    """Return (x̃, w̃, Δt) → (f(x̃, w̃), F, G), F and G as sparse as `predict` has them."""
    n_x = model.n_x
    x_lin, w_lin, dt = ca.SX.sym("x_lin", n_x), ca.SX.sym("w_lin", model.n_w), ca.SX.sym("dt")
    reached, _, _, F, G = predict.call(
        [ca.SX.zeros(n_x), ca.SX.zeros(n_x, n_x), x_lin, w_lin, dt, ca.SX.ones(model.n_w)]
    )
    return ca.Function(
        predict.name(),
        [x_lin, w_lin, dt],
        [reached, F, G],
        ["x_lin", "w_lin", "dt"],
        ["reached", "F", "G"],
        {"cse": True},
    )


def residual_function(model: StateSpaceModel, update: ca.Function) -> ca.Function:
    """Return (x̃, y) → (residual(y, x̃), H) with all rows present, H as sparse as of `update`."""
    x_lin, y = ca.SX.sym("x_lin", model.n_x), ca.SX.sym("y", model.n_y)
    _, _, v, _, _, _, H, _ = update.call(
        [
            ca.SX.zeros(model.n_x),
            ca.SX.zeros(model.n_x, model.n_x),
            x_lin,
            y,
            ca.SX.ones(model.n_r),
        ]
    )
    return ca.Function(
        update.name(), [x_lin, y], [v, H], ["x_lin", "y"], ["residual", "H"], {"cse": True}
    )


def root(covariance: Array) -> Array:
    """Return the lower triangular S (n, n) of a positive definite P = S Sᵀ."""
    return np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)


def in_roots(model: StateSpaceModel, loop: Loop) -> tuple[Loop, dict[str, Any]]:
    """Return a loop with square roots in place of covariances, and what is new in its Model.

    Its functions ``predict`` and ``update`` become those of this module, its tables
    ``…covariance`` their roots.
    """
    found = {function.name(): function for group in loop.functions for function in group}
    predict, update = found["predict"], found["update"]
    linear = {
        "predict": transition_function(model, predict),
        "update": residual_function(model, update),
    }
    changed = dataclasses.replace(
        loop,
        functions=[[linear.get(f.name(), f) for f in group] for group in loop.functions],
        fields={
            name: root(value) if name.endswith("covariance") else value
            for name, value in loop.fields.items()
        },
    )
    n_x, n_w, n_r = model.n_x, model.n_w, model.n_r
    return changed, {
        "noise_std": model.noise_std,
        **_pattern("F", predict.sparsity_out("F")),
        **_pattern("G", predict.sparsity_out("G")),
        **_pattern("H", update.sparsity_out("H")),
        **_pattern("L", update.sparsity_out("L")),
        "v": np.zeros(n_r),
        "e": np.zeros(n_r),
        "along": np.zeros(n_x),
        "array": np.zeros(max(n_x * (n_x + n_w), (n_r + n_x) ** 2)),
    }


def _pattern(name: str, sparsity: ca.Sparsity) -> Mapping[str, Any]:
    """Return where the nonzeros of a matrix stand, and room for them, none for L."""
    rows, columns = (np.array(index, dtype=np.int64) for index in sparsity.get_triplet())
    room = {} if name == "L" else {name: np.zeros(len(rows))}
    return {f"nnz_{name}": len(rows), f"{name}_row": rows, f"{name}_column": columns, **room}
