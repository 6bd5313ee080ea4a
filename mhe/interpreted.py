"""The loop of mhe/window.c in Python, for machines without a C compiler."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from estimation.estimator import remarks
from estimation.function_call import FunctionCall
from estimation.kalman_stage import KalmanStage, Prediction, Update, rows_present, without_gaps
from estimation.layout import Layout
from estimation.recording import Measurement
from estimation.result import report, result_layout, stepped
from estimation.status import Status
from mhe.arrival_cost import ARRIVAL_COSTS, Slide
from mhe.config import MheConfig
from mhe.line_search import FLOOR, ROUNDING, SHORTEST_STEP, SUFFICIENT
from mhe.stage_functions import window_functions
from mhe.window import Trajectory
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
    x, w : optimum of the linearised window
    mu : (n_x,) multiplier of the prior: x_0 = x̄ ⊞ P̄ μ
    length : squared length of the step in whitened units, without the prior's part
    is_finite : whether everything is
    """

    newest: Update
    x: Array
    w: Array
    mu: Array
    length: float
    is_finite: bool


class InterpretedWindow:
    """The engine of the real-time estimators around the interpreted stage.

    Parameters
    ----------
    memory : see `mhe.realtime.window_memory`
    iterates : passes to convergence, or one pass a sample
    """

    def __init__(
        self, model: StateSpaceModel, config: MheConfig, memory: Layout, iterates: bool
    ) -> None:
        self.memory, self.result = memory, result_layout(model)
        self._model, self._config, self._iterates = model, config, iterates
        self._stage = KalmanStage(model)
        functions = window_functions(model, self._stage.functions[0], self._stage.functions[1])
        self._call = {function.name(): FunctionCall(function) for function in functions}
        self._thresholds = config.thresholds([sensor.name for sensor in model.sensors])

    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""
        start, window = time.perf_counter(), View.of(self.memory, given)
        if len(window.times) and time_s < window.times[-1]:
            newest_s = float(window.times[-1])
            late = report(self.result, newest_s, window.newest, None, Status.LATE, iterations=0)
            return given.copy(), late
        memory, result, status = self._attempt(given, time_s, y)
        if Status.NOT_FINITE in status:
            nothing = np.full(self._model.n_y, np.nan)
            memory, result, status = self._attempt(given, time_s, nothing)
            status = status & ~Status.NO_READING | Status.NOT_FINITE
            self.result.view(result, "status")[...] = status.value
        self.result.view(result, "step_time_s")[...] = time.perf_counter() - start
        return memory, result

    def batch(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        """Return the state after n measurements and what each step says, (n, result.size)."""
        return stepped(self, given, time_s, y)

    def solve(self, given: Array) -> tuple[Array, Array]:
        """Converge on a window as it stands; return it solved, and the result."""
        memory = given.copy()
        window = View.of(self.memory, memory)
        newest, status, cost, iterations = self._converge(window)
        state = GaussianState(window.x[-1], newest.state.covariance)
        time_s = float(window.times[-1])
        return memory, report(self.result, time_s, state, newest, status, iterations, cost)

    def _attempt(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array, Status]:
        memory = self._slide(given, time_s, y)
        window = View.of(self.memory, memory)
        if self._iterates:
            newest, status, cost, iterations = self._converge(window)
        else:
            newest, status, cost, iterations = self._one_pass(window)
        state = GaussianState(window.x[-1], newest.state.covariance)
        if not (np.isfinite(state.mean).all() and np.isfinite(state.covariance).all()):
            status |= Status.NOT_FINITE
        window.newest.mean[:], window.newest.covariance[:] = state.mean, state.covariance
        status |= remarks(self._model, state, y, newest.present)
        result = report(self.result, time_s, state, newest, status, iterations, cost)
        return memory, result, status

    def _slide(self, given: Array, time_s: float, y: Array) -> Array:
        """Append an instant, without the oldest stage where the window is full."""
        layout, memory, old = self.memory, given.copy(), View.of(self.memory, given)
        before, capacity = len(old.times), layout.shapes["times"][0]
        dropped = int(before == capacity)
        kept = before - dropped
        layout.view(memory, "count")[...] = kept + 1
        new = View.of(layout, memory)
        for block in ("times", "y", "present", "x", "predicted"):
            getattr(new, block)[:kept] = getattr(old, block)[dropped:]
        new.w[: max(kept - 1, 0)] = old.w[dropped:]
        if dropped:
            prior = self._arrive(old)
            new.prior.mean[:], new.prior.covariance[:] = prior.mean, prior.covariance
        new.times[-1], new.y[-1] = time_s, without_gaps(y)
        new.present[-1] = rows_present(self._model, y)
        new.x[-1] = old.prior.mean
        if before:
            new.w[-1] = 0
            new.x[-1] = self._call["move"](old.x[-1], new.w[-1], time_s - old.times[-1])[0]
        new.predicted[-1] = new.x[-1]
        return memory

    def _arrive(self, window: View) -> GaussianState:
        """Return the prior of the first stage that stays."""
        x, w, y, rows, noises = window.x, window.w, window.y, window.present[0], None
        if self._config.has_losses:
            rows = self._call["measure"](x[0], y[0], rows, self._thresholds)[0]
            noises = self._call["shake"](w[0], self._config.noise_threshold)[0]
        slide = Slide(
            window.prior,
            Measurement(float(window.times[0]), y[0]),
            Measurement(float(window.times[1]), y[1]),
            Trajectory(x, w),
            window.predicted[1],
            rows,
            noises,
        )
        return ARRIVAL_COSTS[self._config.arrival_cost](self._stage, slide)

    def _measure(self, window: View, x: Array, w: Array) -> tuple[float, Scales]:
        """Return the cost of readings and noises, and the scales of their losses."""
        cost, rows, noises = 0.0, np.zeros(window.present.shape), np.ones(w.shape)
        for k, (y, present) in enumerate(zip(window.y, window.present, strict=True)):
            rows[k], row_cost = self._call["measure"](x[k], y, present, self._thresholds)
            cost += float(row_cost[0])
        for k in range(len(w)):
            noises[k], noise_cost = self._call["shake"](w[k], self._config.noise_threshold)
            cost += float(noise_cost[0])
        return cost, Scales(rows, noises)

    def _pass(self, window: View, scales: Scales) -> Pass:
        """Forward with the Kalman stage, back with Bryson-Frazier's, at the trajectory."""
        stage, call, n = self._stage, self._call, len(window.times)
        gaussian, updates, predictions = window.prior, list[Update](), list[Prediction]()
        for k in range(n):
            if k:
                dt = float(window.times[k] - window.times[k - 1])
                at = window.x[k - 1], window.w[k - 1], scales.noises[k - 1]
                predictions.append(stage.predict(gaussian, dt, *at))
                gaussian = predictions[-1].state
            updates.append(stage.update(gaussian, window.y[k], scales.rows[k], window.x[k]))
            gaussian = updates[-1].state
        x, w = np.zeros(window.x.shape), np.zeros(window.w.shape)
        lam, lam_hat, length = np.zeros(0), np.zeros(self._model.n_x), 0.0
        for k in reversed(range(n)):
            if k < n - 1:
                ahead, noise_scale = predictions[k], scales.noises[k]
                lam_hat, w[k] = call["retreat"](lam, ahead.F, ahead.G, noise_scale)
                length += float((((w[k] - window.w[k]) / noise_scale) ** 2).sum())
            u = updates[k]
            stored = u.state.mean, u.state.covariance, lam_hat, u.W, u.e, u.L, u.H
            x[k], lam, part = call["smooth"](*stored, window.x[k])
            length += float(part[0])
        squares = sum(float(update.e @ update.e) for update in updates)
        is_finite = bool(np.isfinite(squares) and np.isfinite(length))
        return Pass(updates[-1], x, w, -lam, length, is_finite)

    def _one_pass(self, window: View) -> tuple[Update, Status, float, int]:
        """Make the linearised window's optimum the trajectory."""
        cost, scales = self._measure(window, window.x, window.w)
        found = self._pass(window, scales)
        if not (found.is_finite and (np.isfinite(cost) or not self._config.has_losses)):
            return found.newest, Status.NOT_FINITE, np.nan, 1
        window.x[:], window.w[:] = found.x, found.w
        return found.newest, Status.SOLVED, np.nan, 1

    def _roll_out(self, window: View, d: Array, w: Array) -> Array:
        """Return the states (n, n_x) that start at x̄ ⊞ d and are driven by w."""
        x = [self._call["retract"](window.prior.mean, d)[0]]
        for k, dt in enumerate(np.diff(window.times)):
            x.append(self._call["move"](x[-1], w[k], dt)[0])
        return np.array(x)

    def _converge(self, window: View) -> tuple[Update, Status, float, int]:
        """Gauss-Newton passes with a line search; see mhe/window.c."""
        config, P = self._config, window.prior.covariance
        [d] = self._call["difference"](window.x[0], window.prior.mean)
        distance, mu_old, began = _prior_distance(P, d), None, time.perf_counter()
        readings, scales = self._measure(window, window.x, window.w)
        J, iterations = readings + distance / 2, 1
        while True:
            found = self._pass(window, scales)
            if not (found.is_finite and np.isfinite(readings)):
                return found.newest, Status.NOT_FINITE, np.nan, iterations
            energy, product = float(found.mu @ P @ found.mu), float(found.mu @ d)
            length = found.length
            if mu_old is not None:
                length += float((found.mu - mu_old) @ P @ (found.mu - mu_old))
            elif np.isfinite(distance):
                length += max(energy - 2 * product + distance, 0.0)
            decrement, alpha = np.sqrt(length), 1.0
            is_last = decrement <= config.tolerance
            while True:
                if alpha < SHORTEST_STEP:
                    status = Status.SOLVED if decrement <= FLOOR else Status.SOLVER_FAILED
                    return found.newest, status, J, iterations
                beta = 1 - alpha
                distance_try = energy
                if alpha != 1:
                    distance_try = (
                        beta**2 * distance + 2 * alpha * beta * product + alpha**2 * energy
                    )
                d_try, w_try = beta * d + alpha * (P @ found.mu), beta * window.w + alpha * found.w
                x_try = self._roll_out(window, d_try, w_try)
                cost, scales_try = self._measure(window, x_try, w_try)
                J_try = cost + distance_try / 2
                slack = ROUNDING * max(1.0, abs(J))
                if J_try <= J - SUFFICIENT * alpha * length + slack:
                    break
                if is_last and np.isfinite(J_try):
                    break
                alpha /= 2
            window.x[:], window.w[:], d, scales = x_try, w_try, d_try, scales_try
            if alpha == 1:
                mu_old = found.mu
            elif mu_old is not None:
                mu_old = beta * mu_old + alpha * found.mu
            J, distance = J_try, distance_try
            if is_last:
                return found.newest, Status.SOLVED, J, iterations
            if iterations >= config.max_iterations:
                return found.newest, Status.ITERATION_LIMIT, J, iterations
            if time.perf_counter() - began > (config.max_time_s or np.inf):
                return found.newest, Status.TIME_LIMIT, J, iterations
            iterations += 1


def _prior_distance(P: Array, d: Array) -> float:
    """Return dᵀ P̄⁻¹ d, infinite where P̄ has no Cholesky factor."""
    try:
        L = np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        return np.inf
    return float((solve_triangular(L, d, lower=True) ** 2).sum())
