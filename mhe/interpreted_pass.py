"""One pass over a window in Python, around the interpreted stage."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from estimation.function_call import FunctionCall
from estimation.kalman_stage import KalmanStage, Prediction, Update
from estimation.layout import Layout
from mhe.config import MheConfig
from mhe.stage_functions import window_functions
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class View:
    """The stages of a window's flat array, as views: see `mhe.realtime.window_memory`."""

    times: Array
    y: Array
    present: Array
    x: Array
    w: Array
    predicted: Array
    prior: GaussianState
    newest: GaussianState

    @classmethod
    def of(cls, layout: Layout, memory: Array) -> View:
        """Look at as many stages as the window has."""
        count = int(layout.view(memory, "count"))
        per_stage = ("times", "y", "present", "x", "predicted")
        times, y, present, x, predicted = (layout.view(memory, b)[:count] for b in per_stage)
        prior, newest = (
            GaussianState(
                layout.view(memory, f"{part}_mean"), layout.view(memory, f"{part}_covariance")
            )
            for part in ("prior", "newest")
        )
        w = layout.view(memory, "w")[: max(count - 1, 0)]
        return cls(times, y, present, x, w, predicted, prior, newest)


@dataclass(frozen=True, eq=False)
class Scales:
    """Scales of the rows (n, n_r) and the noises (n - 1, n_w) by which losses weigh them."""

    rows: Array
    noises: Array


@dataclass(frozen=True, eq=False)
class Pass:
    """Result of a pass over a window.

    Parameters
    ----------
    newest : update of the newest stage
    d : (n, n_x) deviations of the linearised window's optimum from the trajectory
    mu, w : (n_x,), (n - 1, n_w) multiplier of its prior, x_0 = x̄ ⊞ P̄ μ, and its noises
    length : squared length of the step in whitened units, without the prior's part; NaN
        where the pass is not finite
    """

    newest: Update
    d: Array
    mu: Array
    w: Array
    length: float


class WindowPass:
    """Cost, pass and roll-out on a window's views; the equations of mhe/pass.c."""

    def __init__(self, model: StateSpaceModel, config: MheConfig) -> None:
        self.stage = KalmanStage(model)
        functions = window_functions(model, *self.stage.functions)
        self.call = {function.name(): FunctionCall(function) for function in functions}
        self._thresholds = config.thresholds([sensor.name for sensor in model.sensors])
        self._noise_threshold, self._has_losses = config.noise_threshold, config.has_losses

    def measure(self, window: View, x: Array, w: Array) -> tuple[float, Scales]:
        """Return the cost of readings and noises, and the scales of their losses."""
        cost, rows, noises = 0.0, np.zeros(window.present.shape), np.ones(w.shape)
        for k in range(len(x)):
            rows[k], part = self.weigh(window, k, x[k])
            cost += part
        for k in range(len(w)):
            noises[k], noise_cost = self.call["shake"](w[k], self._noise_threshold)
            cost += float(noise_cost[0])
        return cost, Scales(rows, noises)

    def weigh(self, window: View, k: int, x: Array) -> tuple[Array, float]:
        """Return the scales (n_r,) of a stage's rows at x, and their cost."""
        seen = window.y[k], window.present[k], self._thresholds
        rows, cost = self.call["measure"](x, *seen)
        return rows, float(cost[0])

    def run(self, window: View, d: Array, scales: Scales) -> Pass:
        """Forward with the Kalman stage, back with Bryson-Frazier's, from x_0 = x̄ ⊞ d."""
        n = len(window.times)
        updates, predictions = list[Update](), list[Prediction]()
        gaussian, deviation = window.prior, -d
        for k in range(n):
            if k:
                predictions.append(
                    self.stage.predict(
                        gaussian,
                        float(window.times[k] - window.times[k - 1]),
                        window.x[k - 1],
                        window.w[k - 1],
                        scales.noises[k - 1],
                        updates[-1].deviation,
                    )
                )
                gaussian = predictions[-1].state
                [defect] = self.call["difference"](predictions[-1].reached, window.x[k])
                deviation = predictions[-1].deviation + defect
            predicted, at = gaussian, (window.x[k], deviation)
            updates.append(self.stage.update(predicted, window.y[k], scales.rows[k], *at))
            gaussian = updates[-1].state
        d_s, w_s = np.zeros(window.x.shape), np.zeros(window.w.shape)
        lam, lam_hat, length = np.zeros(0), np.zeros(len(d)), 0.0
        for k in reversed(range(n)):
            if k < n - 1:
                ahead, scale = predictions[k], scales.noises[k]
                lam_hat, w_s[k] = self.call["retreat"](lam, ahead.F, ahead.G, scale)
                length += float((((w_s[k] - window.w[k]) / scale) ** 2).sum())
            u = updates[k]
            spread = u.state.covariance @ lam_hat
            stored = u.deviation, spread, lam_hat, u.W, u.e, u.L, u.H
            d_s[k], lam, part = self.call["smooth"](*stored)
            length += float(part[0])
        squares = sum(float(update.e @ update.e) for update in updates)
        finite = np.isfinite(squares) and np.isfinite(length)
        newest = updates[-1]
        if self._has_losses:  # told is the innovation itself, not its weighed share
            told = self.stage.update(predicted, window.y[-1], window.present[-1], *at)
            v, S = told.innovation, told.innovation_covariance
            newest = replace(newest, innovation=v, innovation_covariance=S)
        return Pass(newest, d_s, -lam, w_s, length if finite else np.nan)

    def roll_out(self, window: View, d: Array, w: Array) -> Array:
        """Return the states (n, n_x) that start at x̄ ⊞ d and are driven by w."""
        x = [self.stage.retract(window.prior.mean, d)]
        for k, dt in enumerate(np.diff(window.times)):
            x.append(self.call["move"](x[-1], w[k], dt)[0])
        return np.array(x)
