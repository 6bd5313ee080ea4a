"""The loop of mhe/window.c in Python, for machines without a C compiler."""

from __future__ import annotations

import time

import numpy as np
from scipy.linalg import solve_triangular

from estimation.estimator import remarks
from estimation.kalman_stage import Update, rows_present, without_gaps
from estimation.layout import Layout
from estimation.recording import Measurement
from estimation.result import checked_input, report, result_layout, stepped
from estimation.status import Status
from mhe.arrival_cost import ARRIVAL_COSTS, Slide
from mhe.config import MheConfig
from mhe.descent import MOST_TURNS, WOUND, descend
from mhe.interpreted_pass import Scales, View, WindowPass
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


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
        self._pass = WindowPass(model, config)

    @np.errstate(over="ignore", invalid="ignore")  # an absurd reading: the status says it
    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""
        start = time.perf_counter()
        _, y = checked_input(self.memory, self._model.n_y, given, np.asarray(time_s), y)
        window = View.of(self.memory, given)
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
        return stepped(self, self._model.n_y, given, time_s, y)

    def solve(self, given: Array) -> tuple[Array, Array]:
        """Converge on a window as it stands; return it solved, and the result."""
        memory = given.copy()
        window = View.of(self.memory, memory)
        for k, dt in enumerate(np.diff(window.times)):
            window.x[k + 1] = self._pass.call["move"](window.x[k], window.w[k], dt)[0]
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
            new.x[-1] = self._pass.call["move"](old.x[-1], new.w[-1], time_s - old.times[-1])[0]
        new.predicted[-1] = new.x[-1]
        return memory

    def _arrive(self, window: View) -> GaussianState:
        """Return the prior of the first stage that stays."""
        rows, _ = self._pass.weigh(window, 0, window.x[0])
        noises, _ = self._pass.call["shake"](window.w[0], self._config.noise_threshold)
        slide = Slide(
            window.prior,
            Measurement(float(window.times[0]), window.y[0]),
            Measurement(float(window.times[1]), window.y[1]),
            Trajectory(window.x, window.w),
            window.predicted[1],
            rows,
            noises,
        )
        return ARRIVAL_COSTS[self._config.arrival_cost](self._pass.stage, slide)

    def _one_pass(self, window: View) -> tuple[Update, Status, float, int]:
        """Make the linearised window's optimum the trajectory."""
        cost, scales = 0.0, Scales(window.present, np.ones(window.w.shape))
        if self._config.has_losses:
            cost, scales = self._pass.measure(window, window.x, window.w)
        [d] = self._pass.call["difference"](window.x[0], window.prior.mean)
        found = self._pass.run(window, d, scales)
        if not (np.isfinite(found.length) and np.isfinite(cost)):
            return found.newest, Status.NOT_FINITE, np.nan, 1
        window.w[:] = found.w
        window.x[:] = [self._pass.stage.retract(*p) for p in zip(window.x, found.d, strict=True)]
        return found.newest, Status.SOLVED, np.nan, 1

    def _converge(self, window: View) -> tuple[Update, Status, float, int]:
        """Passes to convergence."""
        point = _Point(self._pass, window)
        if not np.isfinite(point.readings):
            newest = self._pass.run(window, point.d, point.scales).newest
            return newest, Status.NOT_FINITE, np.nan, 1
        end = descend(point, point.z, point.cost, self._config)
        for _ in range(MOST_TURNS):
            if end.status is not Status.SOLVED or not point.is_wound:
                break
            again = _Point(self._pass, window)
            end = descend(again, again.z, again.cost, self._config, end.iterations)
            point = again
        assert point.newest is not None
        return point.newest, end.status, end.cost, end.iterations


class _Point:
    """Current point and candidate of a descent on a window: see `mhe.descent.Descending`."""

    def __init__(self, passes: WindowPass, window: View) -> None:
        self._pass, self._window = passes, window
        self.newest: Update | None = None
        [self.d] = passes.call["difference"](window.x[0], window.prior.mean)
        mu, self.distance = _prior_multiplier(window.prior.covariance, self.d)
        self.z = np.concatenate([mu, window.w.ravel()])
        self.readings, self.scales = passes.measure(window, window.x, window.w)
        self._candidate = self.z, self.d, window.x, self.scales

    @property
    def cost(self) -> float:
        """The window's cost at the point that it began with."""
        return self.readings + self.distance / 2

    @property
    def is_wound(self) -> bool:
        """Whether the first state is nearer to the prior than the deviation says."""
        [short] = self._pass.call["difference"](self._window.x[0], self._window.prior.mean)
        return bool((np.abs(self.d - short) > WOUND * np.maximum(1.0, np.abs(self.d))).any())

    def linearise(self) -> tuple[Array, float]:
        found = self._pass.run(self._window, self.d, self.scales)
        self.newest = found.newest
        step, P = found.mu - self.z[: len(found.mu)], self._window.prior.covariance
        return np.concatenate([found.mu, found.w.ravel()]), found.length + float(step @ P @ step)

    def propose(self, z: Array) -> float:
        window, n_x = self._window, len(self.d)
        mu, w = z[:n_x], z[n_x:].reshape(self._window.w.shape)
        d = window.prior.covariance @ mu
        x = self._pass.roll_out(window, d, w)
        cost, scales = self._pass.measure(window, x, w)
        self._candidate = z, d, x, scales
        return cost + float(mu @ d) / 2

    def take(self) -> None:
        self.z, self.d, self._window.x[:], self.scales = self._candidate
        self._window.w[:] = self.z[len(self.d) :].reshape(self._window.w.shape)

    def inner(self, a: Array, b: Array) -> float:
        n_x, P = len(self.d), self._window.prior.covariance
        return float(a[:n_x] @ P @ b[:n_x] + a[n_x:] @ b[n_x:])


def _prior_multiplier(P: Array, d: Array) -> tuple[Array, float]:
    """Return μ of d = P̄ μ and dᵀ P̄⁻¹ d; zero and infinity where P̄ has no Cholesky factor."""
    try:
        L = np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        return np.zeros(len(d)), np.inf
    z = solve_triangular(L, d, lower=True, check_finite=False)
    mu = solve_triangular(L, z, lower=True, trans=1, check_finite=False)
    return mu, float(z @ z)
