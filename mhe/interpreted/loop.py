"""The loop of mhe/compiled/window.c in Python, for machines without a C compiler."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from estimation.estimator import remarks
from estimation.kalman_stage import Update, rows_present, without_gaps
from estimation.layout import Layout
from estimation.recording import Measurement
from estimation.result import checked_input, report, result_layout, stepped
from estimation.status import Status
from mhe import constraint_rows
from mhe.arrival_cost import ARRIVAL_COSTS, Slide
from mhe.config import Clock, RealTimeConfig
from mhe.interpreted.deadline import Deadline
from mhe.interpreted.descent import LinearisedOptimum, descend
from mhe.interpreted.window_pass import Pass, WindowPass
from mhe.reuse import SETTLED, reuse_threshold
from mhe.rules import MOST_TURNS, WOUND
from mhe.trajectory import Trajectory
from mhe.window_memory import BETWEEN_STAGES, PER_STAGE, Scales, View
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class Solved:
    """How solving a window ended.

    Parameters
    ----------
    newest : update of the newest stage; None where there was no pass
    covariance : (n_x, n_x) of the newest state
    kkt : see `estimation.estimate.Estimate.kkt_residual`
    """

    newest: Update | None
    covariance: Array
    status: Status
    iterations: int = 0
    cost: float = np.nan
    kkt: float = np.nan


class InterpretedWindow:
    """The engine of the real-time estimators around the interpreted stage.

    Parameters
    ----------
    memory : see `mhe.window_memory.window_memory`
    clock : for deadlines; None is the machine's own
    """

    def __init__(
        self,
        model: StateSpaceModel,
        config: RealTimeConfig,
        memory: Layout,
        clock: Clock | None = None,
    ) -> None:
        self.memory, self.result = memory, result_layout(model)
        self._model, self._config, self._scheme = model, config, config.scheme
        self._pass = WindowPass(model, config)
        self._reuse = reuse_threshold(model, config)
        self._deadline = Deadline(config.deadline_s, clock or time.perf_counter)

    @np.errstate(over="ignore", invalid="ignore")  # an absurd reading: the status says it
    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""
        self._deadline.begin()
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
        self.result.view(result, "step_time_s")[...] = self._deadline.passed_s
        return memory, result

    def batch(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        """Return the state after n measurements and what each step says, (n, result.size)."""
        return stepped(self, self._model.n_y, given, time_s, y)

    def solve(self, given: Array) -> tuple[Array, Array]:
        """Converge on a window as it stands; return it solved, and the result."""
        memory = given.copy()
        self._deadline.begin()
        window = View.of(self.memory, memory)
        for k, dt in enumerate(np.diff(window.times)):
            window.x[k + 1] = self._pass.call["move"](window.x[k], window.w[k], dt)[0]
        solved = self._converge(window)
        state = GaussianState(window.x[-1], solved.covariance)
        return memory, self._report(window, state, solved, solved.status)

    def _attempt(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array, Status]:
        old, capacity = View.of(self.memory, given), self.memory.shapes["times"][0]
        count, most = min(len(old.times) + 1, capacity), self._deadline.affordable(capacity)
        near = self._staying(old, self._reuse**2)
        stays = max(near, count - most)
        has_time = stays <= self._staying(old, np.inf)
        memory = self._slide(given, time_s, y, stays)
        window = View.of(self.memory, memory)
        if not has_time:
            state, solved = self._only_predict(old, window)
        else:
            solved = self._converge(window) if self._scheme.converges else self._one_pass(window)
            state = GaussianState(window.x[-1], solved.covariance)
        status = solved.status
        if has_time and stays > near:
            status |= Status.TIME_LIMIT
        if not (np.isfinite(state.mean).all() and np.isfinite(state.covariance).all()):
            status |= Status.NOT_FINITE
        window.newest.mean[:], window.newest.covariance[:] = state.mean, state.covariance
        status |= remarks(self._model, state, y, window.present[-1] > 0)
        return memory, self._report(window, state, solved, status), status

    def _report(self, window: View, state: GaussianState, solved: Solved, status: Status) -> Array:
        figures = solved.iterations, solved.cost, solved.kkt
        time_s = float(window.times[-1])
        return report(self.result, time_s, state, solved.newest, status, *figures)

    def _only_predict(self, old: View, window: View) -> tuple[GaussianState, Solved]:
        """Return the newest state as predicted from the last estimate."""
        self._deadline.note_none()
        covariance = window.newest.covariance
        if len(old.times):
            dt = float(window.times[-1] - old.times[-1])
            last = GaussianState(old.x[-1], old.newest.covariance)
            covariance = self._pass.stage.predict(last, dt).state.covariance
        state = GaussianState(window.x[-1].copy(), covariance)
        return state, Solved(None, covariance, Status.PREDICTED)

    def _staying(self, old: View, limit: float) -> int:
        """Return how many stages of the window to come keep their factors, as window.c does."""
        if not self._reuse > 0:
            return 0
        moved = ~(np.isfinite(old.moved) & (old.moved <= limit))
        k = int(moved.argmax()) if moved.any() else len(moved)
        return max(k - int(len(moved) == self.memory.shapes["times"][0]), 0)

    def _choose_points(self, window: View, k: int) -> None:
        """Choose what the next pass is linearised at: the first k stages keep their points."""
        step = max(k - 1, 0)  # the noise that leads to stage k goes with it
        window.x_lin[k:], window.w_lin[step:] = window.x[k:], window.w[step:]
        window.moved[k:] = np.inf  # until a pass says
        if k == 0:
            [deviation] = self._pass.call["difference"](window.x_lin[0], window.prior.mean)
            window.prior_deviation[:] = -deviation

    def _slide(self, given: Array, time_s: float, y: Array, stays: int) -> Array:
        """Append an instant, without the oldest stage where the window is full."""
        layout, memory, old = self.memory, given.copy(), View.of(self.memory, given)
        before, capacity = len(old.times), layout.shapes["times"][0]
        dropped = int(before == capacity)
        kept = before - dropped
        layout.view(memory, "count")[...] = kept + 1
        new = View.of(layout, memory)
        for block in PER_STAGE:
            getattr(new, block)[:kept] = getattr(old, block)[dropped:]
        for block in BETWEEN_STAGES:
            getattr(new, block)[: max(kept - 1, 0)] = getattr(old, block)[dropped:]
        if dropped:
            prior, new.prior_deviation[:] = self._arrive(old, stays > 0)
            new.prior.mean[:], new.prior.covariance[:] = prior.mean, prior.covariance
        new.demanded[-1], new.active[-1] = constraint_rows.demanded(self._model, y), 0
        new.times[-1], new.y[-1] = time_s, without_gaps(y)
        new.present[-1] = rows_present(self._model, y)
        new.x[-1] = old.prior.mean
        if before:
            new.w[-1] = 0
            new.x[-1] = self._pass.call["move"](old.x[-1], new.w[-1], time_s - old.times[-1])[0]
        new.predicted[-1] = new.x[-1]
        self._choose_points(new, stays)
        new.stayed[...] = stays
        return memory

    def _arrive(self, window: View, kept: bool) -> tuple[GaussianState, Array]:
        """Return the prior of the first stage that stays, and its deviation from its point.

        Where factors are kept the dropped stage is eliminated as its own were made.
        """
        if kept:
            stage, dt = self._pass.stage, float(window.times[1] - window.times[0])
            at = window.x_lin[0], window.prior_deviation
            updated = stage.update(window.prior, window.y[0], window.present[0], *at)
            point = window.x_lin[0], window.w_lin[0], None, updated.deviation
            predicted = stage.predict(updated.state, dt, *point)
            [defect] = self._pass.call["difference"](predicted.reached, window.x_lin[1])
            return predicted.state, predicted.deviation + defect
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
        prior = ARRIVAL_COSTS[self._config.arrival_cost](self._pass.stage, slide)
        [deviation] = self._pass.call["difference"](prior.mean, window.x_lin[1])
        return prior, deviation

    def _one_pass(self, window: View) -> Solved:
        """Make the linearised window's optimum the trajectory."""
        began = self._deadline.now()
        cost, scales = 0.0, Scales(window.present, np.ones(window.w.shape))
        if self._config.has_losses:
            cost, scales = self._pass.measure(window, window.x, window.w)
        at = window.x_lin, window.w_lin
        settled = SETTLED * self._reuse
        found = self._pass.run(window, -window.prior_deviation, scales, *at, settled)
        if not (np.isfinite(found.length) and np.isfinite(cost)):
            return Solved(found.newest, found.covariances[-1], Status.NOT_FINITE, 1)
        self._deadline.note_pass(len(window.times) - int(window.stayed), began)
        window.w[:] = found.w
        renewed = slice(found.oldest, None)
        for k in range(len(window.times))[renewed]:
            window.x[k] = self._pass.stage.retract(window.x_lin[k], found.d[k])
        if self._reuse > 0:
            for k, by in list(enumerate(_moved(found)))[renewed]:
                window.moved[k] = self._judged(window, k, by, found.expected[k])
        kkt = max(np.sqrt(found.length), self._largest_excess(window, found.row_std))
        return Solved(found.newest, found.covariances[-1], found.held.status, 1, kkt=kkt)

    def _judged(self, window: View, k: int, by: float, expected: Array) -> float:
        """Return how far a stage is from its linearisation point, squared, as one_pass.c does."""
        if by > self._reuse**2:
            return by
        [off] = self._pass.call["judge"](window.x[k], window.y[k], window.present[k], expected)
        return max(by, float(off[0]) ** 2)

    def _largest_excess(self, window: View, row_std: Array) -> float:
        """Return what the trajectory exceeds a row by at most, in standard deviations."""
        excess = self._pass.excess(window, window.x)
        exceeded = excess > 0
        return float((excess[exceeded] / row_std[exceeded]).max(initial=0.0))

    def _converge(self, window: View) -> Solved:
        """Passes to convergence."""
        point = _WindowPoint(self._pass, window, self._deadline)
        if not np.isfinite(point.readings):
            found = self._pass.run(window, point.d, point.scales)
            return Solved(found.newest, found.covariances[-1], Status.NOT_FINITE, 1)
        end = descend(point, point.z, point.cost, self._scheme)
        for _ in range(MOST_TURNS):
            if end.status is not Status.SOLVED or not point.is_wound:
                break
            again = _WindowPoint(self._pass, window, self._deadline)
            end = descend(again, again.z, again.cost, self._scheme, end.iterations)
            point = again
        assert point.found is not None
        found = point.found
        kkt = max(end.kkt, self._largest_excess(window, found.row_std))
        covariance = found.covariances[-1]
        return Solved(found.newest, covariance, end.status, end.iterations, end.cost, kkt)


class _WindowPoint:
    """Current point and candidate of a descent: see `mhe.interpreted.descent.Descending`."""

    def __init__(self, passes: WindowPass, window: View, deadline: Deadline) -> None:
        self._pass, self._window, self._deadline = passes, window, deadline
        self.found: Pass | None = None
        self.is_constrained = passes.n_c > 0
        [self.d] = passes.call["difference"](window.x[0], window.prior.mean)
        mu, self.distance = _prior_multiplier(window.prior.covariance, self.d)
        self.z = np.concatenate([mu, window.w.ravel()])
        self.readings, self.scales = passes.measure(window, window.x, window.w)
        self._weights = np.zeros(passes.n_c)
        self._violation = self._tried = passes.excess(window, window.x).sum(axis=0)
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

    def is_late(self) -> bool:
        count = len(self._window.times)
        return self._deadline.affordable(count) < count

    def linearise(self) -> LinearisedOptimum:
        began, before = self._deadline.now(), self._window.active.copy()
        self.found = found = self._pass.run(self._window, self.d, self.scales)
        self._deadline.note_pass(len(self._window.times), began)
        multipliers = found.held.multipliers.reshape(-1, max(self._pass.n_c, 1))
        if found.held.active.any():
            self._weights = np.maximum(self._weights, 2 * multipliers.max(axis=0))
        step, P = found.mu - self.z[: len(found.mu)], self._window.prior.covariance
        return LinearisedOptimum(
            np.concatenate([found.mu, found.w.ravel()]),
            found.length + float(step @ P @ step),
            found.held.status,
            bool((before != self._window.active).any()),
        )

    def propose(self, z: Array) -> float:
        window, n_x = self._window, len(self.d)
        mu, w = z[:n_x], z[n_x:].reshape(self._window.w.shape)
        d = window.prior.covariance @ mu
        x = self._pass.roll_out(window, d, w)
        cost, scales = self._pass.measure(window, x, w)
        self._candidate = z, d, x, scales
        self._tried = self._pass.excess(window, x).sum(axis=0)
        return cost + float(mu @ d) / 2

    def penalty(self) -> float:
        return float(self._weights @ self._violation)

    def penalty_tried(self) -> float:
        return float(self._weights @ self._tried)

    def take(self) -> None:
        self.z, self.d, self._window.x[:], self.scales = self._candidate
        self._window.w[:] = self.z[len(self.d) :].reshape(self._window.w.shape)
        self._violation = self._tried

    def inner(self, a: Array, b: Array) -> float:
        n_x, P = len(self.d), self._window.prior.covariance
        return float(a[:n_x] @ P @ b[:n_x] + a[n_x:] @ b[n_x:])


def _moved(found: Pass) -> Array:
    """Return the largest squared deviation (n,) of the stages, in variances."""
    variances = np.diagonal(found.covariances, axis1=1, axis2=2)
    squares = found.d**2
    ratios = np.zeros(squares.shape)
    np.divide(squares, variances, out=ratios, where=squares > 0)
    largest: Array = ratios.max(axis=1)
    return largest


def _prior_multiplier(P: Array, d: Array) -> tuple[Array, float]:
    """Return μ of d = P̄ μ and dᵀ P̄⁻¹ d; zero and infinity where P̄ has no Cholesky factor."""
    try:
        L = np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        return np.zeros(len(d)), np.inf
    z = solve_triangular(L, d, lower=True, check_finite=False)
    mu = solve_triangular(L, z, lower=True, trans=1, check_finite=False)
    return mu, float(z @ z)
