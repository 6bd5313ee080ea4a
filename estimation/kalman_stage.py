"""The Kalman stage: predict and update, symbolically, at any linearisation point.

The stage that the EKF and every pass of an optimisation-based estimator share. States are
x = x̃ ⊞ δ around a trajectory (x̃, w̃) that may differ from the filter's own mean:

    predict:  δ⁻ = F δ⁺ - G w̃ around f(x̃, w̃),   P⁻ = F P⁺ Fᵀ + G D² Gᵀ
    update:   v = residual(y, x̃) - H δ⁻,   L Lᵀ = H P⁻ Hᵀ + R
              W = P⁻ Hᵀ L⁻ᵀ,   e = L⁻¹ v
              δ⁺ = δ⁻ + W e,   P⁺ = P⁻ - W Wᵀ

with ⊞ the model's ``retract``, ⊟ its ``difference``, F, G and H derivatives along the
tangent space at (x̃, w̃). A missing row has its row of v and H zero; a loss other than
least squares scales rows of v and H, and the noises by D. Deviations, not means, are
carried from stage to stage: an angle may deviate by more than a turn before it wraps, and
the pass stays the linear solve that it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from estimation import in_order
from estimation.function_call import FunctionCall
from estimation.outputs import derived_outputs
from estimation.square_roots import LOST, kept, predicted_root, root_of, updated_root
from estimation.status import Status
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


def _symmetric(matrix: ca.SX) -> ca.SX:
    """Mirror the lower triangle: half the work, symmetric to the last bit."""
    return ca.tril2symm(ca.tril(matrix))


def predict_function(model: StateSpaceModel) -> ca.Function:
    """Return the symbolic predict stage of a model.

    (δ⁺ (n_x,), P⁺ (n_x, n_x), x̃ (n_x,), w̃ (n_w,), Δt, diagonal of D (n_w,))
    → (f(x̃, w̃), δ⁻, P⁻, F, G); F and G are sparse.
    """
    n_x, n_w = model.n_x, model.n_w
    d_plus, x_lin = ca.SX.sym("d_plus", n_x), ca.SX.sym("x_lin", n_x)
    w_lin, dt = ca.SX.sym("w_lin", n_w), ca.SX.sym("dt")
    P_plus, noise_scale = ca.SX.sym("P_plus", n_x, n_x), ca.SX.sym("noise_scale", n_w)

    reached, F, G = step_derivatives(model, x_lin, w_lin, dt)
    d_minus = in_order.less(in_order.product(F, d_plus), G, w_lin)
    GD = G @ ca.diag(noise_scale)
    half = in_order.product(F, _symmetric(P_plus))
    P_minus = in_order.product(F, half.T, more=_symmetric(GD @ GD.T))
    return ca.Function(
        "predict",
        [d_plus, P_plus, x_lin, w_lin, dt, noise_scale],
        [*(ca.densify(value) for value in (reached, d_minus, P_minus)), F, G],
        ["d_plus", "P_plus", "x_lin", "w_lin", "dt", "noise_scale"],
        ["reached", "d_minus", "P_minus", "F", "G"],
        {"cse": True},
    )


def step_derivatives(
    model: StateSpaceModel, x: ca.SX, w: ca.SX, dt: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return f(x, w), F (n_x, n_x) and G (n_x, n_w) along the tangent spaces; sparse."""
    reached = model.f(x, w, dt)
    out = difference_jacobian(model, reached)
    F = out @ ca.jacobian(reached, x) @ retract_jacobian(model, x)
    return reached, F, out @ ca.jacobian(reached, w)


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
    """Return the residuals (n_r,) of all sensors for stacked readings y (n_y,)."""
    rows, start = [ca.SX(0, 1)], 0
    for sensor in model.sensors:
        rows.append(sensor.residual(y[start : start + sensor.n_y], x))
        start += sensor.n_y
    return ca.vertcat(*rows)


def update_function(model: StateSpaceModel) -> ca.Function:
    """Return the symbolic update stage of a model.

    (δ⁻, P⁻, x̃, y (n_y,), present (n_r,)) → (δ⁺, P⁺, v, S, W, e, H, L); `present` is
    1 for rows that have a reading and 0 for missing ones, whose y must be finite. H
    and L are sparse.
    """
    n_x = model.n_x
    d_minus, x_lin = ca.SX.sym("d_minus", n_x), ca.SX.sym("x_lin", n_x)
    P_minus = ca.SX.sym("P_minus", n_x, n_x)
    y, present = ca.SX.sym("y", model.n_y), ca.SX.sym("present", model.n_r)

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
    """Return what every estimator's loop calls, ``predict`` and ``update`` first."""
    return [
        predict_function(model),
        update_function(model),
        retract_function(model),
        regularity_function(model),
        *([] if model.outputs is None else [derived_outputs(model).function]),
    ]


@dataclass(frozen=True, eq=False)
class Prediction:
    """Result of a prediction.

    Parameters
    ----------
    state : x⁻ and P⁻
    reached, deviation : f(x̃, w̃) and δ⁻ (n_x,), of which x⁻ is made
    F, G : (n_x, n_x), (n_x, n_w)
    """

    state: GaussianState
    reached: Array
    deviation: Array
    F: Array
    G: Array


@dataclass(frozen=True, eq=False)
class Update:
    """Result of an update.

    Parameters
    ----------
    state : x⁺ and P⁺
    deviation : δ⁺ (n_x,), of x⁺ from the linearisation point
    innovation : v (n_r,), zero in missing rows
    innovation_covariance : S (n_r, n_r)
    W, e, H, L : (n_x, n_r), (n_r,), (n_r, n_x), (n_r, n_r), what a backward pass needs
    present : (n_r,) rows that had a reading
    """

    state: GaussianState
    deviation: Array
    innovation: Array
    innovation_covariance: Array
    W: Array
    e: Array
    H: Array
    L: Array
    present: NDArray[np.bool_]


class KalmanStage:
    """The stage's two functions on NumPy arrays, by CasADi's virtual machine.

    Loops in C have a stage of their own (estimation/covariance_stage.c), which says the same to the
    last bit.

    One instance belongs to one estimator: it owns work buffers.

    Attributes
    ----------
    digits_lost : set by an update whose reading leaves fewer than two digits; whoever says it to
        people takes it back
    """

    def __init__(self, model: StateSpaceModel) -> None:
        self.model = model
        self.functions = (predict_function(model), update_function(model))
        self._predict, self._update = (FunctionCall(f) for f in self.functions)
        self._retract = FunctionCall(retract_function(model))
        self._difference = FunctionCall(difference_function(model))
        self._no_noise, self._unit_noise = np.zeros(model.n_w), np.ones(model.n_w)
        self._no_deviation, self.digits_lost = np.zeros(model.n_x), False

    def predict(
        self,
        state: GaussianState,
        dt: float,
        x_lin: Array | None = None,
        w_lin: Array | None = None,
        noise_scale: Array | None = None,
        deviation: Array | None = None,
    ) -> Prediction:
        """Return x⁻, P⁻ after `dt` seconds, linearised at (x_lin, w_lin).

        The filter's own mean and no noise are the default linearisation point.

        Parameters
        ----------
        noise_scale : (n_w,) standard deviations of the noises; ones by default
        deviation : (n_x,) δ⁺ of the mean from x_lin, where it is known; it may be longer
            than the difference of two states can tell
        """
        n_x = self.model.n_x
        reached, d_minus, P_minus, F, G = self._predict(
            self._deviation(state.mean, x_lin) if deviation is None else deviation,
            state.covariance,
            state.mean if x_lin is None else x_lin,
            self._no_noise if w_lin is None else w_lin,
            dt,
            self._unit_noise if noise_scale is None else noise_scale,
        )
        F, G, P_minus = F.reshape(n_x, n_x), G.reshape(n_x, -1), P_minus.reshape(n_x, n_x)
        predicted = GaussianState(self.retract(reached, d_minus), P_minus)
        grows = np.diag(P_minus) > LOST * np.diag(state.covariance)
        if state.root is not None or grows.any():
            noise = G if noise_scale is None else G * noise_scale
            predicted = kept(predicted.mean, predicted_root(root_of(state), F, noise))
        return Prediction(predicted, reached, d_minus, F, G)

    def retract(self, x: Array, deviation: Array) -> Array:
        """Return x ⊞ δ (n_x,)."""
        return self._retract(x, deviation)[0]

    def difference(self, to: Array, origin: Array) -> Array:
        """Return to ⊟ origin (n_x,)."""
        return self._difference(to, origin)[0]

    def _deviation(self, mean: Array, x_lin: Array | None) -> Array:
        return self._no_deviation if x_lin is None else self._difference(mean, x_lin)[0]

    def derivatives(
        self, x_lin: Array, dt: float, w_lin: Array | None = None
    ) -> tuple[Array, Array]:
        """Return F (n_x, n_x) and G (n_x, n_w) of a step of `dt` seconds at (x_lin, w_lin)."""
        no_covariance = np.zeros((self.model.n_x, self.model.n_x))
        prediction = self.predict(GaussianState(x_lin, no_covariance), dt, x_lin, w_lin)
        return prediction.F, prediction.G

    def update(
        self,
        state: GaussianState,
        y: Array,
        present: NDArray[np.bool_] | Array | None = None,
        x_lin: Array | None = None,
        deviation: Array | None = None,
    ) -> Update:
        """Condition x⁻, P⁻ on stacked readings, NaN where missing, linearised at x_lin.

        Parameters
        ----------
        deviation : (n_x,) δ⁻, as for `predict`
        present : (n_r,) rows to use, or their scales; those of `rows_present` by default
        """
        if present is None:
            present = rows_present(self.model, y)
        at = state.mean if x_lin is None else x_lin
        d_minus = self._deviation(state.mean, x_lin) if deviation is None else deviation
        given = d_minus, state.covariance, at, without_gaps(y), present
        d_plus, P_plus, v, S, W, e, H, L = self._update(*given)
        n_x, n_r = self.model.n_x, self.model.n_r
        H, L = H.reshape(n_r, n_x), L.reshape(n_r, n_r)
        S, W, P_plus = S.reshape(n_r, n_r), W.reshape(n_x, n_r), P_plus.reshape(n_x, n_x)
        updated = GaussianState(self.retract(at, d_plus), P_plus)
        there = np.asarray(present) != 0
        squares = np.diag(L)[there] ** 2
        falls = (squares > LOST * self.model.noise_std[there] ** 2) | np.isnan(squares)
        overflows = np.isinf(squares).any() or not np.isfinite(H).all()
        if not overflows and (state.root is not None or falls.any() or (np.diag(P_plus) < 0).any()):
            root = updated_root(root_of(state), H, self.model.noise_std, there)
            self.digits_lost |= root.digits_lost
            W, L, S = root.W, root.L, root.L @ root.L.T
            e, d_plus = v.copy(), np.array(d_minus, dtype=float)
            for r in range(n_r):
                e[r] /= L[r, r]
                e[r + 1 :] -= L[r + 1 :, r] * e[r]
                d_plus += W[:, r] * e[r]
            updated = kept(self.retract(at, d_plus), root.S)
        S[~there, :] = S[:, ~there] = 0
        S[~there, ~there] = self.model.noise_std[~there] ** 2
        return Update(updated, d_plus, v, S, W, e, H, L, there)

    def remark(self) -> Status:
        """Return whether an update since the last call has lost its digits."""
        lost, self.digits_lost = self.digits_lost, False
        return Status.DIGITS_LOST if lost else Status.SOLVED

    def output_matrix(self, x: Array, y: Array) -> Array:
        """Return H (n_r, n_x) of stacked readings at a state; rows without a reading are zero."""
        no_covariance = np.zeros((self.model.n_x, self.model.n_x))
        return self.update(GaussianState(x, no_covariance), y).H


def rows_present(model: StateSpaceModel, y: Array) -> NDArray[np.bool_]:
    """Return which rows (n_r,) of the stacked residual have all readings they need.

    A reading that is NaN, infinite or at its sensor's range limit counts as missing.
    """
    usable = np.abs(y) < model.saturation
    missing: NDArray[np.bool_] = model.row_needs @ ~usable
    return ~missing


def without_gaps(y: Array) -> Array:
    """Return readings (n_y,) with zero where there is none, as symbols need numbers."""
    return np.where(np.isfinite(y), y, 0.0)
