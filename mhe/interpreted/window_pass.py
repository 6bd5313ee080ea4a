"""One pass over a window in Python, around the interpreted stage."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.kalman_stage import Prediction, Update
from estimation.lagged import LaggedState
from estimation.status import Status
from mhe.config import WindowConfig
from mhe.interpreted.active_set import ActiveSet, Held
from mhe.interpreted.pass_result import Forward, Pass, Smoothed
from mhe.interpreted.window_trajectory import WindowTrajectory
from mhe.look_back import Smoother, look_back, told_stages
from mhe.rules import most_active
from mhe.window_memory import Scales, View
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


class WindowPass(WindowTrajectory):
    """Cost, pass and roll-out on a window's views; the equations of mhe/compiled/*.c."""

    def __init__(self, model: StateSpaceModel, config: WindowConfig) -> None:
        super().__init__(model, config)
        self._capacity = most_active(config.horizon + 1, self.n_c)
        self._lags, self._smoother = config.lags, Smoother(self.call)

    def run(
        self,
        window: View,
        d: Array,
        scales: Scales,
        x: Array | None = None,
        w: Array | None = None,
        settled: float | None = None,
    ) -> Pass:
        """Make a pass from x_0 = x̄ ⊞ d; mark the rows that hold its optimum as active.

        Parameters
        ----------
        x, w : what to linearise at; the window's trajectory by default
        settled : where the pass back may end, see `_renew`; None goes back through all stages
        """
        prior, deviation, J = window.prior, -d, None
        if x is None and "carry" in self.call:
            [J] = self.call["carry"](prior.mean, d, window.x[0])
            prior, deviation = GaussianState(prior.mean, J @ prior.covariance @ J.T), -J @ d
        x, w = window.x if x is None else x, window.w if w is None else w
        forward = self._forward(window, prior, deviation, scales, x, w)
        if settled is None:
            found = self._backward(window, forward, w)
        else:
            found = self._renew(window, forward, w, settled)
        held, row_std = Held(np.zeros(0), np.zeros(0, bool), Status.SOLVED), window.demanded
        added = 0.0
        if self.n_c and np.isfinite(found.length):
            held, row_std, C, added = self._held(window, forward, found.d, x)
            window.active[:] = held.active.reshape(window.active.shape)
            if held.active.any():
                impulses = np.einsum("kj,kij->ki", held.multipliers.reshape(row_std.shape), C)
                found = self._backward(window, forward, w, impulses)
        newest, tells = forward.updates[-1], forward.updates[window.told]
        squares = sum(float(update.e @ update.e) for update in forward.updates)
        finite = np.isfinite(squares) and np.isfinite(found.length)
        if self._has_losses:  # told is the innovation itself, not its weighed share
            k, at = window.told, prior
            if k > 0:
                ahead = forward.predictions[k - 1]
                at, deviation = ahead.state, ahead.deviation + self._defect(ahead, x[k])
            tells = self.stage.update(at, window.y[k], window.present[k], x[k], deviation)
        v, S, present = tells.innovation, tells.innovation_covariance, tells.present
        newest = replace(newest, innovation=v, innovation_covariance=S, present=present)
        covariances = np.array([update.state.covariance for update in forward.updates])
        found = found if finite else replace(found, length=np.nan)
        found = found if J is None else replace(found, mu=J.T @ found.mu)
        return Pass(
            **vars(found),
            newest=newest,
            covariances=covariances,
            held=held,
            row_std=row_std,
            cost=squares / 2 + added,
            forward=forward,
        )

    def _defect(self, prediction: Prediction, x: Array) -> Array:
        return self.call["difference"](prediction.reached, x)[0]

    def _forward(
        self,
        window: View,
        prior: GaussianState,
        deviation: Array,
        scales: Scales,
        x: Array,
        w: Array,
    ) -> Forward:
        """Kalman stages from the deviation δ⁻ and the covariance of the first."""
        updates, predictions, gaussian = list[Update](), list[Prediction](), prior
        for k in range(len(window.times)):
            if k:
                dt = float(window.times[k] - window.times[k - 1])
                at = x[k - 1], w[k - 1], scales.noises[k - 1], updates[-1].deviation
                inputs = self.stage.model.step_inputs(window.y[k - 1], window.y[k])
                predictions.append(self.stage.predict(gaussian, dt, *at, inputs=inputs))
                gaussian = predictions[-1].state
                deviation = predictions[-1].deviation + self._defect(predictions[-1], x[k])
            updates.append(
                self.stage.update(gaussian, window.y[k], scales.rows[k], x[k], deviation)
            )
            gaussian = updates[-1].state
        return Forward(updates, predictions, scales.noises)

    def _backward(
        self, window: View, forward: Forward, w: Array, impulses: Array | None = None
    ) -> Smoothed:
        """Bryson-Frazier back, with impulses (n, n_x) on the costates."""
        n, n_x = window.x.shape
        d_s, w_s, length = np.zeros((n, n_x)), np.zeros(w.shape), 0.0
        expected = np.zeros(window.present.shape)
        pushed = np.zeros((n, n_x)) if impulses is None else impulses
        d_shift, e_shift = self._pushed(forward, pushed)
        lam, lam_hat = np.zeros(n_x), np.zeros(n_x)
        for k in reversed(range(n)):
            if k < n - 1:
                ahead, scale = forward.predictions[k], forward.noises[k]
                lam_hat, w_s[k] = self.call["retreat"](lam, ahead.F, ahead.G, scale)
                length += float((((w_s[k] - w[k]) / scale) ** 2).sum())
            lam_hat = lam_hat + pushed[k]
            u = forward.updates[k]
            shifted = u.deviation + d_shift[k], u.e + e_shift[k]
            d_s[k], lam, part, expected[k] = self._smooth(u, lam_hat, *shifted)
            length += part
        return Smoothed(d_s, -lam, w_s, length, expected, 0)

    def _renew(self, window: View, forward: Forward, w: Array, settled: float) -> Smoothed:
        """Go back to the first stage without news; see mhe/compiled/one_pass.c.

        Parameters
        ----------
        settled : how far, in standard deviations, a stage may be off that is not gone back to
        """
        n, n_x = window.x.shape
        d_s, w_s, oldest = np.zeros((n, n_x)), window.w.copy(), 0
        expected = np.zeros(window.present.shape)
        stayed = int(window.stayed) if self.n_c == 0 else 0
        lam, lam_hat = np.zeros(n_x), np.zeros(n_x)
        for k in reversed(range(n)):
            if k < n - 1:
                ahead, scale = forward.predictions[k], forward.noises[k]
                lam_hat, w_s[k] = self.call["retreat"](lam, ahead.F, ahead.G, scale)
            u = forward.updates[k]
            if k < stayed:
                shift = lam_hat - window.costate[k]
                moves = np.sqrt(max(shift @ self._smoother.spread(u.state, shift), 0.0))
                if moves + window.away[:k].sum() <= settled:
                    window.away[k], oldest = moves, k + 1
                    self._smooth_told(forward, d_s, k, lam_hat)
                    break
            window.costate[k], window.away[k] = lam_hat, 0
            smoothed = self._smooth(u, lam_hat, u.deviation, u.e)
            d_s[k], lam, window.length[k], expected[k] = smoothed
            if k < n - 1:
                window.length[k] += (((w_s[k] - w[k]) / forward.noises[k]) ** 2).sum()
        length = float(window.length.sum())
        return Smoothed(d_s, -lam, w_s, length, expected, oldest)

    def _smooth_told(self, forward: Forward, d_s: Array, newest: int, lam_hat: Array) -> None:
        """Smooth the stages up to `newest` that a lag speaks of, for nobody else; one_pass.c."""
        told, lam = [at for _, at in told_stages(self._lags, len(d_s))], lam_hat
        for k in reversed(range(min(told, default=len(d_s)), newest + 1)):
            if k < newest:
                ahead, scale = forward.predictions[k], forward.noises[k]
                lam_hat, _ = self.call["retreat"](lam, ahead.F, ahead.G, scale)
            u = forward.updates[k]
            d_s[k], lam, _, _ = self._smooth(u, lam_hat, u.deviation, u.e)

    def look_back(self, window: View, states: Array, found: Pass | None) -> tuple[LaggedState, ...]:
        """Return what a window with these states (n, n_x) says at its lags; None had no pass."""
        covariances: dict[int, Array] = {}
        if found is not None and self._lags:
            forward = found.forward
            factors = forward.updates, forward.predictions
            covariances = self._smoother.covariances(self._lags, *factors)
        return look_back(self._lags, window.times, states, covariances)

    def _smooth(
        self, u: Update, lam_hat: Array, deviation: Array, e: Array
    ) -> tuple[Array, Array, float, Array]:
        """Return a stage's smoothed deviation, λ in front of it, length, expected residuals."""
        spread = self._smoother.spread(u.state, lam_hat)
        smoothed = self.call["smooth"](deviation, spread, lam_hat, u.W, e, u.L, u.H)
        d_s, lam, part, expected = smoothed
        return d_s, lam, float(part[0]), expected

    def _pushed(self, forward: Forward, impulses: Array) -> tuple[Array, Array]:
        """Return what impulses change in δ⁺ (n, n_x), before their own stage's, and in e."""
        d_shift = np.zeros(impulses.shape)
        e_shift = np.zeros((len(impulses), len(forward.updates[0].e)))
        if not impulses.any():
            return d_shift, e_shift
        for k in range(1, len(impulses)):
            before, here = forward.updates[k - 1], forward.updates[k]
            shift = d_shift[k - 1] - self._smoother.spread(before.state, impulses[k - 1])
            F = forward.predictions[k - 1].F
            e_shift[k], d_shift[k] = self.call["propagate"](shift, F, here.W, here.L, here.H)
        return d_shift, e_shift

    def _held(
        self, window: View, forward: Forward, d_s: Array, x: Array
    ) -> tuple[Held, Array, Array, float]:
        """Return the active set, the rows' standard deviations, C (n, n_x, n_c), the set's cost."""
        rows = [self.call["constrain"](state) for state in x]
        n, n_x = x.shape
        g, C = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
        C = C.reshape(n, n_x, self.n_c)
        P = np.array([update.state.covariance for update in forward.updates])
        std = np.sqrt(np.maximum(np.einsum("kij,kil,klj->kj", C, P, C), 0))
        values = np.where(window.demanded > 0, g + np.einsum("kij,ki->kj", C, d_s), -np.inf)

        def respond(row: int) -> Array:
            impulses = np.zeros((n, n_x))
            k, j = divmod(row, self.n_c)
            impulses[k] = C[k, :, j]
            return self._response(forward, impulses, C)

        search = ActiveSet(values.ravel(), std.ravel(), respond, self._capacity)
        held = search.find(window.active.ravel() > 0)
        added = float(held.multipliers[held.active] @ values.ravel()[held.active]) / 2
        return held, std, C, added

    def _response(self, forward: Forward, impulses: Array, C: Array) -> Array:
        """Return what impulses take from the values of all rows (n n_c,)."""
        d_shift, e_shift = self._pushed(forward, impulses)
        n = len(impulses)
        response, lam = np.zeros((n, C.shape[2])), np.zeros(impulses.shape[1])
        lam_hat = lam
        for k in reversed(range(n)):
            if k < n - 1:
                ahead, scale = forward.predictions[k], forward.noises[k]
                lam_hat, _ = self.call["retreat"](lam, ahead.F, ahead.G, scale)
            lam_hat = lam_hat + impulses[k]
            u = forward.updates[k]
            response[k] = C[k].T @ (self._smoother.spread(u.state, lam_hat) - d_shift[k])
            [lam] = self.call["absorb"](lam_hat, u.W, e_shift[k], u.L, u.H)
        return response.ravel()
