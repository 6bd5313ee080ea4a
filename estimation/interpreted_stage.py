"""The Kalman stage by CasADi's virtual machine, for machines without a C compiler."""

from __future__ import annotations

import casadi as ca
import numpy as np

from estimation.function_call import FunctionCall
from estimation.square_roots import LOST, kept, predicted_root, root_of, updated_root
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


class InterpretedStage:
    """Predict and update of a model, as `estimation.compiled_stage` has them."""

    def __init__(self, model: StateSpaceModel, predict: ca.Function, update: ca.Function) -> None:
        self._model, self._digits_lost = model, False
        self._predict, self._update = FunctionCall(predict), FunctionCall(update)

    def predict(
        self,
        deviation: Array,
        state: GaussianState,
        x: Array,
        w: Array,
        dt: float,
        scale: Array,
        *inputs: Array,
    ) -> tuple[Array, Array, GaussianState, Array, Array]:
        """Return f(x̃, w̃), δ⁻, P⁻ around no mean yet, F (n_x, n_x) and G (n_x, n_w)."""
        n_x = self._model.n_x
        found = self._predict(deviation, state.covariance, x, w, dt, scale, *inputs)
        reached, d_minus, P, F, G = found
        F, G, P = F.reshape(n_x, n_x), G.reshape(n_x, -1), P.reshape(n_x, n_x)
        grows = np.diag(P) > LOST * np.diag(state.covariance)
        if state.root is None and not grows.any():
            return reached, d_minus, GaussianState(state.mean, P), F, G
        known = kept(state.mean, predicted_root(root_of(state), F, G * scale))
        return reached, d_minus, known, F, G

    def update(
        self, deviation: Array, state: GaussianState, x: Array, y: Array, present: Array
    ) -> tuple[Array, GaussianState, Array, Array, Array, Array, Array, Array]:
        """Return δ⁺, P⁺ around no mean yet, v, S, W (n_x, n_r), e, H (n_r, n_x), L (n_r, n_r)."""
        n_x, n_r, noise_std = self._model.n_x, self._model.n_r, self._model.noise_std
        d_plus, P, v, S, W, e, H, L = self._update(deviation, state.covariance, x, y, present)
        H, L, P = H.reshape(n_r, n_x), L.reshape(n_r, n_r), P.reshape(n_x, n_x)
        S, W, known = S.reshape(n_r, n_r), W.reshape(n_x, n_r), GaussianState(state.mean, P)
        there = present != 0
        squares = np.diag(L)[there] ** 2
        falls = (squares > LOST * noise_std[there] ** 2) | np.isnan(squares)
        overflows = np.isinf(squares).any() or not np.isfinite(H).all()
        if not overflows and (state.root is not None or falls.any() or (np.diag(P) < 0).any()):
            root = updated_root(root_of(state), H, noise_std, there)
            self._digits_lost |= root.digits_lost
            W, L, S = root.W, root.L, root.L @ root.L.T
            e, d_plus = v.copy(), np.array(deviation, dtype=float)
            for r in range(n_r):
                e[r] /= L[r, r]
                e[r + 1 :] -= L[r + 1 :, r] * e[r]
                d_plus += W[:, r] * e[r]
            known = kept(state.mean, root.S)
        S[~there, :] = S[:, ~there] = 0
        S[~there, ~there] = noise_std[~there] ** 2
        return d_plus, known, v, S, W, e, H, L

    def sweep(self, P: GaussianState, x: Array, dt: Array, y: Array, present: Array) -> Array:
        """Return the covariances (n, n_x, n_x) behind n rows; see `KalmanStage.sweep`."""
        model, known, found = self._model, P, []
        no_deviation, no_noise, ones = np.zeros(model.n_x), np.zeros(model.n_w), np.ones(model.n_w)
        for k in range(len(x)):
            if k > 0:
                ends = model.step_inputs(y[k - 1], y[k])
                step = (x[k - 1], no_noise, float(dt[k]), ones, *ends)
                _, _, known, _, _ = self.predict(no_deviation, known, *step)
            _, known, *_ = self.update(no_deviation, known, x[k], y[k], present[k])
            found.append(known.covariance)
        return np.array(found)

    def lost(self) -> bool:
        """Return whether a reading since the last call has left fewer than two digits."""
        lost, self._digits_lost = self._digits_lost, False
        return lost
