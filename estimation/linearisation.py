"""A model linearised, as loops in C call it: generated functions, and where their numbers stand.

    transition:  (x̃, w̃, Δt, D, u, u⁺) → f(x̃, w̃), F, G, Q = G D² Gᵀ
    readings:    (x̃, y) → residual, H

with F, G and H derivatives along the tangent space at (x̃, w̃), all that CasADi writes of a stage.
A model with known inputs has those at both ends of a step, u and u⁺; they end y, too.
The algebra behind them is plain C: estimation/covariance_stage.c and estimation/root_stage.c.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from estimation.stored import stride
from estimation.symbolic_stage import (
    functions_beside,
    residual_derivative,
    stacked_residual,
    step_derivatives,
    step_symbols,
    unit_diagonal,
)
from models.state_space import StateSpaceModel

TRANSITION, READINGS = "transition", "readings"


def transition_function(model: StateSpaceModel) -> ca.Function:
    """Return (x̃ (n_x,), w̃ (n_w,), Δt, diagonal of D (n_w,), …) → (f(x̃, w̃), Fᵀ, G, Q), all sparse.

    C reads a matrix's nonzeros in the order in which it sums: F row by row, and G column by column.
    Of F those ones are left out that stand on its diagonal whatever the state (`unit_diagonal`
    of `estimation.symbolic_stage`). Of Q, which is symmetric, there is the lower triangle. Behind
    D stand the inputs, as of `step_symbols` there.
    """
    x, w, dt = ca.SX.sym("x", model.n_x), ca.SX.sym("w", model.n_w), ca.SX.sym("dt")
    noise_scale = ca.SX.sym("noise_scale", model.n_w)
    inputs = step_symbols(model)
    reached, F, G = step_derivatives(model, x, w, dt, *inputs.values())
    GD = G @ ca.diag(noise_scale)
    return ca.Function(
        TRANSITION,
        [x, w, dt, noise_scale, *inputs.values()],
        [
            ca.densify(reached),
            ca.sparsify(F - ca.diag(ca.DM(unit_diagonal(model)))).T,
            G,
            ca.tril(GD @ GD.T),
        ],
        ["x", "w", "dt", "noise_scale", *inputs],
        ["reached", "F_rows", "G", "Q"],
        {"cse": True},
    )


def readings_function(model: StateSpaceModel) -> ca.Function:
    """Return (x̃ (n_x,), y (n_row,)) → (residual(y, x̃) (n_r,), Hᵀ), all rows as if present."""
    x, y = ca.SX.sym("x", model.n_x), ca.SX.sym("y", model.n_row)
    residual = stacked_residual(model, y, x)
    H = residual_derivative(model, residual, x)
    return ca.Function(
        READINGS, [x, y], [ca.densify(residual), H.T], ["x", "y"], ["residual", "H_rows"],
        {"cse": True},
    )  # fmt: skip


@lru_cache(maxsize=16)
def loop_functions(model: StateSpaceModel) -> tuple[ca.Function, ...]:
    """Return what every estimator's loop in C calls, transition and readings first."""
    return (
        transition_function(model),
        readings_function(model),
        *functions_beside(model),
    )


def stage_fields(
    model: StateSpaceModel, functions: Sequence[ca.Function], form: str
) -> dict[str, Any]:
    """Return the part of C's structure Model that its stage needs: patterns, noise, and room.

    Parameters
    ----------
    functions : those of `loop_functions`, and others
    form : of the stage, one of `estimation.loop.STAGES`
    """
    found = {function.name(): function for function in functions}
    transition, readings = found[TRANSITION], found[READINGS]
    n_x, n_w, n_r = model.n_x, model.n_w, model.n_r
    row, unit = stride(n_x), unit_diagonal(model)
    in_roots = max(n_x * (n_x + n_w), (n_r + n_x) ** 2)
    own, array = _covariance_fields(model, transition) if form == "covariance" else ({}, 0)
    return {
        **_compressed("F", transition.sparsity_out(1), "column"),
        "F_unit": np.array([*unit, *[0] * (row - n_x)], dtype=float),
        **_compressed("G", transition.sparsity_out(2), "row"),
        **_compressed("H", readings.sparsity_out(1), "column"),
        "noise_std": np.asarray(model.noise_std, dtype=float),
        "v": np.zeros(n_r),
        "e": np.zeros(n_r),
        "L": np.zeros(triangle(n_r)),
        "along": np.zeros(n_x),
        "array": np.zeros(max(in_roots, array)),
        "lost": np.zeros(1),
        **own,
    }


def _covariance_fields(
    model: StateSpaceModel, transition: ca.Function
) -> tuple[dict[str, Any], int]:
    """Return what only the stage in covariances needs, and the size of its array."""
    row, n_r = stride(model.n_x), model.n_r
    fields = {
        **_places("Q", transition.sparsity_out(3)),
        "W": np.zeros((n_r, row)),
        "rows": np.zeros(n_r, dtype=np.int64),
        "factor": np.zeros(max(n_r, model.n_x)),
        "root": np.zeros((row, row)),
    }
    return fields, 2 * row * row


def _places(name: str, pattern: ca.Sparsity) -> dict[str, Any]:
    """Return where the nonzeros of a lower triangle go in an array of rows, and room for them."""
    row = stride(pattern.size1())
    i, j = (np.array(x, dtype=np.int64) for x in pattern.get_triplet())
    room = {f"{name}_entries": np.zeros(len(i)), name: np.zeros((row, row))}
    return {f"nnz_{name}": len(i), f"{name}_low": i * row + j, f"{name}_high": j * row + i, **room}


def triangle(n: int) -> int:
    """Return how many numbers a lower triangle of n rows has."""
    return n * (n + 1) // 2


def _compressed(name: str, pattern: ca.Sparsity, index: str) -> dict[str, Any]:
    """Return where each column of a pattern begins, its nonzeros' rows, and room for these."""
    starts, entries = (np.array(x, dtype=np.int64) for x in (pattern.colind(), pattern.row()))
    return {f"{name}_at": starts, f"{name}_{index}": entries, name: np.zeros(len(entries))}
