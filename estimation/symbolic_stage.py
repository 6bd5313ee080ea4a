"""The Kalman stage in symbols; the equations are in `estimation.kalman_stage`."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from estimation import in_order
from estimation.outputs import derived_outputs
from models.state_space import StateSpaceModel


def _symmetric(matrix: ca.SX) -> ca.SX:
    """Mirror the lower triangle: half the work, symmetric to the last bit."""
    return ca.tril2symm(ca.tril(matrix))


@lru_cache(maxsize=16)
def predict_function(model: StateSpaceModel) -> ca.Function:
    """Return the symbolic predict stage of a model.

    (δ⁺ (n_x,), P⁺ (n_x, n_x), x̃ (n_x,), w̃ (n_w,), Δt, diagonal of D (n_w,), `step_symbols`)
    → (f(x̃, w̃), δ⁻, P⁻, F, G); F and G are sparse.
    """
    n_x, n_w = model.n_x, model.n_w
    d_plus, x_lin = ca.SX.sym("d_plus", n_x), ca.SX.sym("x_lin", n_x)
    w_lin, dt = ca.SX.sym("w_lin", n_w), ca.SX.sym("dt")
    P_plus, noise_scale = ca.SX.sym("P_plus", n_x, n_x), ca.SX.sym("noise_scale", n_w)

    inputs = step_symbols(model)
    reached, F, G = step_derivatives(model, x_lin, w_lin, dt, *inputs.values())
    d_minus = in_order.less(in_order.product(F, d_plus), G, w_lin)
    GD = G @ ca.diag(noise_scale)
    half = in_order.product(F, _symmetric(P_plus))
    P_minus = in_order.product(F, half.T, more=_symmetric(GD @ GD.T))
    return ca.Function(
        "predict",
        [d_plus, P_plus, x_lin, w_lin, dt, noise_scale, *inputs.values()],
        [*(ca.densify(value) for value in (reached, d_minus, P_minus)), F, G],
        ["d_plus", "P_plus", "x_lin", "w_lin", "dt", "noise_scale", *inputs],
        ["reached", "d_minus", "P_minus", "F", "G"],
        {"cse": True},
    )


def step_symbols(model: StateSpaceModel) -> dict[str, ca.SX]:
    """Return name → symbol (n_u,) of the inputs at both ends of a step; none without inputs."""
    names = ("u", "u_next") if model.n_u else ()
    return {name: ca.SX.sym(name, model.n_u) for name in names}


def step_derivatives(
    model: StateSpaceModel, x: ca.SX, w: ca.SX, dt: ca.SX, *inputs: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return f(x, w), F (n_x, n_x) and G (n_x, n_w) along the tangent spaces; sparse.

    Parameters
    ----------
    inputs : as of `step_symbols`
    """
    reached = model.f(x, w, dt, *inputs)
    out = difference_jacobian(model, reached)
    F = out @ ca.jacobian(reached, x) @ retract_jacobian(model, x)
    return reached, F, out @ ca.jacobian(reached, w)


@lru_cache(maxsize=16)
def unit_diagonal(model: StateSpaceModel) -> tuple[int, ...]:
    """Return 1 for each row (n_x) of F whose diagonal is the number one at every state, else 0."""
    x, w, dt = ca.SX.sym("x", model.n_x), ca.SX.sym("w", model.n_w), ca.SX.sym("dt")
    inputs = step_symbols(model).values()
    return tuple(in_order.unit_rows(step_derivatives(model, x, w, dt, *inputs)[1]))


def residual_derivative(model: StateSpaceModel, residual: ca.SX, x: ca.SX) -> ca.SX:
    """Return H (n_r, n_x) of a residual at x, minus its derivative along the tangent space."""
    return -(ca.jacobian(residual, x) @ retract_jacobian(model, x))


def retract_jacobian(model: StateSpaceModel, x: ca.SX) -> ca.SX:
    """Return ∂(x ⊞ δ)/∂δ (n_x, n_x) at δ = 0; the identity where states add."""
    delta = ca.SX.sym("delta", model.n_x)
    B = ca.jacobian(model.retract(x, delta), delta)
    return ca.sparsify(ca.substitute(B, delta, ca.SX.zeros(model.n_x)))


def difference_jacobian(model: StateSpaceModel, x: ca.SX) -> ca.SX:
    """Return ∂(z ⊟ x)/∂z (n_x, n_x) at z = x, the inverse of `retract_jacobian`."""
    z, at = ca.SX.sym("z", model.n_x), ca.SX.sym("at", model.n_x)
    E = ca.substitute(ca.jacobian(model.difference(z, at), z), z, at)
    return ca.sparsify(ca.substitute(E, at, x))


def stacked_residual(model: StateSpaceModel, y: ca.SX, x: ca.SX) -> ca.SX:
    """Return the residuals (n_r,) of all sensors for a row y (n_row,) of readings and inputs."""
    rows, start, u = [ca.SX(0, 1)], 0, y[model.n_y :]
    for sensor in model.sensors:
        readings = y[start : start + sensor.n_y]
        rows.append(sensor.residual(readings, x, *sensor.inputs_of(u)))
        start += sensor.n_y
    return ca.vertcat(*rows)


@lru_cache(maxsize=16)
def update_function(model: StateSpaceModel) -> ca.Function:
    """Return the symbolic update stage of a model.

    (δ⁻, P⁻, x̃, y (n_row,), present (n_r,)) → (δ⁺, P⁺, v, S, W, e, H, L); `present` is
    1 for rows that have a reading and 0 for missing ones, whose y must be finite. H
    and L are sparse.
    """
    n_x = model.n_x
    d_minus, x_lin = ca.SX.sym("d_minus", n_x), ca.SX.sym("x_lin", n_x)
    P_minus = ca.SX.sym("P_minus", n_x, n_x)
    y, present = ca.SX.sym("y", model.n_row), ca.SX.sym("present", model.n_r)

    residual = stacked_residual(model, y, x_lin)
    H = present * residual_derivative(model, residual, x_lin)
    v = in_order.less(present * residual, H, d_minus)
    L, Wt, e = in_order.whitened(H, P_minus, v, model.noise_std)
    d_plus, P_plus, S = d_minus, P_minus, L @ L.T
    for r in range(model.n_r):
        d_plus = d_plus + Wt[r, :].T * e[r]
        P_plus = P_plus - Wt[r, :].T @ Wt[r, :]
    P_plus = _symmetric(P_plus)
    return ca.Function(
        "update",
        [d_minus, P_minus, x_lin, y, present],
        [*(ca.densify(value) for value in (d_plus, P_plus, v, S, Wt.T, e)), H, L],
        ["d_minus", "P_minus", "x_lin", "y", "present"],
        ["d_plus", "P_plus", "v", "S", "W", "e", "H", "L"],
        {"cse": True},
    )


def regularity_function(model: StateSpaceModel) -> ca.Function:
    """Return the model's margin from singular coordinates, (n_x,) → ()."""
    x = ca.SX.sym("x", model.n_x)
    return ca.Function("regularity", [x], [ca.densify(model.regularity(x))], ["x"], ["margin"])


def retract_function(model: StateSpaceModel) -> ca.Function:
    """Return the model's ``retract`` under its own name, dense: (x, δ) → x ⊞ δ."""
    x, delta = ca.SX.sym("x", model.n_x), ca.SX.sym("delta", model.n_x)
    moved = ca.densify(model.retract(x, delta))
    return ca.Function("retract", [x, delta], [moved], ["x", "delta"], ["moved"])


def difference_function(model: StateSpaceModel) -> ca.Function:
    """Return the model's ``difference`` under its own name, dense: (a, b) → a ⊟ b."""
    x, origin = ca.SX.sym("x", model.n_x), ca.SX.sym("origin", model.n_x)
    delta = ca.densify(model.difference(x, origin))
    return ca.Function("difference", [x, origin], [delta], ["x", "origin"], ["delta"])


def stage_functions(model: StateSpaceModel) -> list[ca.Function]:
    """Return what an interpreted loop calls, ``predict`` and ``update`` first."""
    return [predict_function(model), update_function(model), *functions_beside(model)]


def functions_beside(model: StateSpaceModel) -> list[ca.Function]:
    """Return what every estimator's loop calls beside its stage."""
    return [
        retract_function(model),
        regularity_function(model),
        *([] if model.outputs is None else [derived_outputs(model).function]),
    ]
