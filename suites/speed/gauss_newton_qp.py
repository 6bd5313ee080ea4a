"""A Gauss-Newton step of a window as a sparse QP, its numbers from compiled stage functions.

    min  ½ zᵀ P z + qᵀ z   s.t.   l ≤ A z ≤ u,      z = (δ_0, ω_0, δ_1, …, δ_N)

in the variables of `suites.speed.stagewise`, linearised at the warm start. H, F and G
are derivatives along δ and ω, residuals r in standard deviations:

    P = diag(L̄⁻ᵀ L̄⁻¹ + H_0ᵀ H_0, I, H_1ᵀ H_1, I, …),   q = (…, H_kᵀ r_k, w̃_k, …)
    A = rows (-F_k, -G_k, I),                        l = u = D⁻¹ (f(x̃_k, w̃_k) ⊟ x̃_{k+1})

and, for every state i with a bound and every stage, a row

    D_i⁻¹ (lower_i - x̃_ki) ≤ δ_ki ≤ D_i⁻¹ (upper_i - x̃_ki)

The functions of one stage are compiled once and mapped over the window; where each of
their nonzeros stands in P and A is found once, by matrices of labels.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy.sparse as sp

from estimation.native import compiled
from estimation.symbolic_stage import stacked_residual
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.speed.stagewise import bounded_states
from suites.speed.tangent import along, away, moved
from suites.speed.windows import SpeedWindow


@dataclass(frozen=True, eq=False)
class GaussNewtonQp:
    """The QP of windows of one model and length.

    Parameters
    ----------
    numbers : casadi.Function of `qp_arguments` → nonzeros of P, q, nonzeros of A, l, u
    P, A : matrices of the right pattern, P its upper triangle
    """

    numbers: ca.Function
    P: sp.csc_matrix
    A: sp.csc_matrix

    @classmethod
    def build(cls, model: StateSpaceModel, horizon: int) -> GaussNewtonQp:
        """Write down and compile the functions of a stage, and put the stages together."""
        n_x, n_w, n_y, n_r, N = model.n_x, model.n_w, model.n_y, model.n_r, horizon
        first, seen, moved = (
            compiled(function) for function in (_first(model), _seen(model), linear_gap(model))
        )
        x_prior, L_inverse = ca.MX.sym("x_prior", n_x), ca.MX.sym("L_inverse", n_x, n_x)
        y, present = ca.MX.sym("y", n_y, N + 1), ca.MX.sym("present", n_r, N + 1)
        dt, scale = ca.MX.sym("dt", 1, N), ca.MX.sym("scale", n_x)
        x, w = ca.MX.sym("x", n_x, N + 1), ca.MX.sym("w", n_w, N)

        P_0, q_0 = first(x[:, 0], y[:, 0], present[:, 0], scale, x_prior, L_inverse)
        scales = ca.repmat(scale, 1, N)
        P_k, q_k = seen.map(N)(x[:, 1:], y[:, 1:], present[:, 1:], scales)
        F, G, b = moved.map(N)(x[:, :N], w, dt, x[:, 1:], scales)

        start_of_P = _labels(first.sparsity_out(0), 1, 1)[0]
        later = _labels(seen.sparsity_out(0), 1 + start_of_P.nnz, N)
        eye_w, eye_x = sp.eye_array(n_w), sp.eye_array(n_x)  # label 1: the constant one
        diagonal = [start_of_P, *(block for P in later for block in (eye_w, P))]
        P = sp.block_diag(diagonal, format="csc")
        F_labels = _labels(moved.sparsity_out(0), 1, N)
        G_labels = _labels(moved.sparsity_out(1), 1 + F.nnz(), N)
        bounded = bounded_states(model)
        rows: list[list[sp.sparray | None]] = [[None] * (2 * N + 1) for _ in range(N)]
        for k in range(N):
            rows[k][2 * k : 2 * k + 3] = [F_labels[k], G_labels[k], eye_x]
        for k in range(N + 1 if bounded else 0):
            rows.append([None] * (2 * N + 1))
            rows[-1][2 * k] = eye_x.tocsr()[bounded]
        A = sp.block_array(rows, format="csc")
        low, high = (
            ca.vec((ca.repmat(bound[bounded], 1, N + 1) - x[bounded, :]) / scale[bounded])
            for bound in (model.lower, model.upper)
        )

        one = ca.MX(1)
        numbers = ca.Function(
            "gauss_newton_qp",
            [x_prior, L_inverse, y, present, dt, scale, x, w],
            [
                _picked(P, one, P_0, P_k),
                ca.vertcat(ca.vec(ca.vertcat(ca.horzcat(q_0, q_k)[:, :N], w)), q_k[:, N - 1]),
                _picked(A, one, F, G),
                ca.vertcat(ca.vec(b), low),
                ca.vertcat(ca.vec(b), high),
            ],
        )
        return cls(numbers, sp.csc_matrix(P), sp.csc_matrix(A))


def qp_arguments(window: SpeedWindow) -> list[Array]:
    """Return the arguments of the QP's numbers, flat, linearised at the warm start."""
    return [
        window.prior.mean,
        window.prior_factor_inverse.ravel(order="F"),
        window.y.ravel(),
        window.present.ravel().astype(float),
        window.dt,
        window.scale,
        window.guess.states.ravel(),
        window.guess.noises.ravel(),
    ]


def _labels(pattern: ca.Sparsity, first: int, count: int) -> list[sp.csc_array]:
    """Return `count` matrices of a pattern whose nonzeros are numbered from `first` + 1."""
    n = pattern.nnz()
    return [
        sp.csc_array(
            (first + 1 + k * n + np.arange(n), np.array(pattern.row()), np.array(pattern.colind())),
            shape=pattern.shape,
        )
        for k in range(count)
    ]


def _picked(labels: sp.csc_array, *values: ca.MX) -> ca.MX:
    """Return the values (n,) behind a matrix of labels, column by column."""
    flat = ca.vertcat(*(ca.vertcat(value.nz[:]) for value in values))
    return flat.nz[(labels.data.astype(int) - 1).tolist()]


def linear_residual(model: StateSpaceModel) -> tuple[list[ca.SX], ca.SX, ca.SX]:
    """Return (x, y, present, scale), the residual r of a stage and H = ∂r/∂δ."""
    x, y = ca.SX.sym("x", model.n_x), ca.SX.sym("y", model.n_y)
    present, scale = ca.SX.sym("present", model.n_r), ca.SX.sym("scale", model.n_x)
    d = ca.SX.sym("d", model.n_x)

    def seen(at: ca.SX) -> ca.SX:
        return present * stacked_residual(model, y, at) / model.noise_std

    H = along(seen(moved(model, x, d)), d) @ ca.diag(scale)
    return [x, y, present, scale], seen(x), H


def _seen(model: StateSpaceModel) -> ca.Function:
    given, r, H = linear_residual(model)
    return ca.Function("seen", given, [ca.triu(H.T @ H), ca.densify(H.T @ r)], {"cse": True})


def linear_prior(model: StateSpaceModel) -> ca.Function:
    """Return the function (x, scale, prior x, L̄⁻¹) → (r, W): the prior's residual r + W δ."""
    x, scale = ca.SX.sym("x", model.n_x), ca.SX.sym("scale", model.n_x)
    x_prior, d = ca.SX.sym("x_prior", model.n_x), ca.SX.sym("d", model.n_x)
    L_inverse = ca.SX.sym("L_inverse", model.n_x, model.n_x)
    lower = ca.tril(L_inverse)
    W = lower @ along(away(model, moved(model, x, d), x_prior), d) @ ca.diag(scale)
    r = lower @ away(model, x, x_prior)
    return ca.Function("linear_prior", [x, scale, x_prior, L_inverse], [r, W])


def _first(model: StateSpaceModel) -> ca.Function:
    (x, *others), r, H = linear_residual(model)
    x_prior = ca.SX.sym("x_prior", model.n_x)
    L_inverse = ca.SX.sym("L_inverse", model.n_x, model.n_x)
    r_prior, W = linear_prior(model)(x, others[-1], x_prior, L_inverse)
    P, q = W.T @ W + H.T @ H, W.T @ r_prior + H.T @ r
    return ca.Function(
        "first", [x, *others, x_prior, L_inverse], [ca.triu(P), ca.densify(q)], {"cse": True}
    )


def linear_gap(model: StateSpaceModel) -> ca.Function:
    """Return the function (x, w, Δt, next x, scale) → (-F, -G, b), along δ and ω."""
    x, w, dt = ca.SX.sym("x", model.n_x), ca.SX.sym("w", model.n_w), ca.SX.sym("dt")
    x_next, scale = ca.SX.sym("x_next", model.n_x), ca.SX.sym("scale", model.n_x)
    d = ca.SX.sym("d", model.n_x)

    def gap(at: ca.SX) -> ca.SX:
        return away(model, model.f(at, w, dt), x_next) / scale

    F, G = along(gap(moved(model, x, d)), d) @ ca.diag(scale), ca.jacobian(gap(x), w)
    given = [x, w, dt, x_next, scale]
    return ca.Function("moved", given, [-F, -G, ca.densify(gap(x))], {"cse": True})
