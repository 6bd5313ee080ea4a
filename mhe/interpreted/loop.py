"""The loop of mhe/compiled/window.c in Python, for machines without a C compiler."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from estimation.estimator import remarks
from estimation.inputs import with_inputs, without_readings
from estimation.kalman_stage import rows_present
from estimation.lagged import LaggedState
from estimation.layout import Layout
from estimation.outputs import derived_outputs
from estimation.report import report
from estimation.rest_detector import RestDetector
from estimation.result import checked_input, result_layout, stepped
from estimation.status import Status
from mhe.config import Clock, RealTimeConfig
from mhe.interpreted.convergence import Convergence, Solved
from mhe.interpreted.deadline import Deadline
from mhe.interpreted.first_passes import is_first, settled
from mhe.interpreted.pass_result import Pass
from mhe.interpreted.sliding import WindowSlider
from mhe.interpreted.window_pass import WindowPass
from mhe.late import ALONE, StagePlace, place_of, readings_there
from mhe.look_back import told_stages
from mhe.reuse import SETTLED, reuse_threshold
from mhe.window_memory import Scales, View, put
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


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
        self.memory, self.result = memory, result_layout(model, config.lags)
        self._derived = derived_outputs(model)
        self._model, self._config, self._scheme = model, config, config.scheme
        self._pass, self._rest = WindowPass(model, config), RestDetector(model)
        self._slider = WindowSlider(model, config, memory, self._pass)
        self._reuse = reuse_threshold(model, config)
        self._deadline = Deadline(config.deadline_s, clock or time.perf_counter)
        self._convergence = Convergence(self._pass, config, self._deadline)

    @np.errstate(over="ignore", invalid="ignore")  # an absurd reading: the status says it
    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""
        self._deadline.begin()
        _, y = checked_input(self.memory, self._model, given, np.asarray(time_s), y)
        window = View.of(self.memory, given)
        there = [readings_there(self._model, present) for present in window.present]
        place = place_of(window.times, there, self.memory.shapes["times"][0], time_s, y)
        if place.at < 0:
            return given.copy(), self._refused(window, Status.LATE)
        before = self.memory.view(given, "inputs")
        before = window.y[place.before, self._model.n_y :] if place.is_late else before
        y = with_inputs(self._model, before, y)
        rest = self._rest.part(self.memory, given)
        if not place.is_late:
            dt = time_s - float(window.times[-1]) if len(window.times) else 0.0
            rest, y = self._rest.step(rest, dt, y)
        memory, result, status = self._attempt(given, place, time_s, y)
        if Status.NOT_FINITE in status:
            if place.is_late:
                return given.copy(), self._refused(window, Status.NOT_FINITE)
            nothing = without_readings(self._model, y)
            memory, result, status = self._attempt(given, place, time_s, nothing)
            if Status.NOT_FINITE in status:
                memory, result = self._begin_anew(window, time_s, nothing)
                status |= Status.NO_READING
            else:
                status = status & ~Status.NO_READING | Status.NOT_FINITE
            self.result.view(result, "status")[...] = status.value
        self._rest.part(self.memory, memory)[:] = rest
        self.result.view(result, "step_time_s")[...] = self._deadline.passed_s
        return memory, result

    def _refused(self, window: View, status: Status) -> Array:
        """Return what is said of a late measurement that changes nothing."""
        at, newest = (self.result, self._derived, float(window.times[-1])), window.newest
        result = report(*at, newest, None, status, iterations=0)
        self.result.view(result, "step_time_s")[...] = self._deadline.passed_s
        return result

    def batch(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        """Return the state after n measurements and what each step says, (n, result.size)."""
        return stepped(self, self._model, given, time_s, y)

    def solve(self, given: Array) -> tuple[Array, Array]:
        """Converge on a window as it stands; return it solved, and the result."""
        memory = given.copy()
        self._deadline.begin()
        window = View.of(self.memory, memory)
        window.x[:] = self._pass.states_from(window, window.x[0], window.w)
        solved = self._judge(window, self._convergence.solve(window))
        state = replace(solved.known, mean=window.x[-1])
        return memory, self._report(window, state, solved, solved.status)

    def _begin_anew(self, window: View, time_s: float, nothing: Array) -> tuple[Array, Array]:
        """Begin a window with the last estimate, where not even its prediction is finite."""
        memory = np.zeros(self.memory.size)
        for part in ("prior", "newest"):
            put(self.memory, memory, part, window.newest)
        self.memory.view(memory, "seen")[:] = window.seen
        memory, result, _ = self._attempt(memory, ALONE, time_s, nothing)
        return memory, result

    def _attempt(
        self, given: Array, place: StagePlace, time_s: float, y: Array
    ) -> tuple[Array, Array, Status]:
        old, capacity = View.of(self.memory, given), self.memory.shapes["times"][0]
        count = len(old.times) + int(not place.joins) - place.drop
        most = self._deadline.affordable(capacity)
        near = self._staying(old, place, self._reuse**2)
        stays = max(near, count - most)
        has_time = stays <= self._staying(old, place, np.inf)
        memory, window = self._slider.slide(given, place, time_s, y, min(stays, place.at))
        rows = rows_present(self._model, y) if place.joins else window.present[place.at] > 0
        settles = is_first(self._model, window, rows) and place.is_late
        if not has_time:
            state, solved = self._only_predict(old, window, place)
        else:
            solved = self._solve(window, settles)
            if stays > near:
                solved = replace(solved, status=solved.status | Status.TIME_LIMIT)
            solved = self._judge(window, solved)
            state = replace(solved.known, mean=window.x[-1])
        if place.joins:
            solved = self._told_of(solved, rows)
        status = solved.status
        if not (np.isfinite(state.mean).all() and np.isfinite(state.covariance).all()):
            status |= Status.NOT_FINITE
        put(self.memory, memory, "newest", state)
        status |= remarks(self._model, state, y, rows) | self._pass.stage.remark()
        return memory, self._report(window, state, solved, status), status

    def _told_of(self, solved: Solved, rows: NDArray[np.bool_]) -> Solved:
        """Tell of some rows of a stage only; the others have their noise alone in S."""
        if solved.newest is None:
            return solved
        S = np.diag(self._model.noise_std * self._model.noise_std)
        own = np.ix_(rows, rows)
        S[own] = solved.newest.innovation_covariance[own]
        newest = replace(solved.newest, innovation_covariance=S, present=rows)
        return replace(solved, newest=newest)

    def _report(self, window: View, state: GaussianState, solved: Solved, status: Status) -> Array:
        figures = solved.iterations, solved.cost, solved.kkt, solved.lagged, self._config.lags
        time_s = float(window.times[-1])
        return report(self.result, self._derived, time_s, state, solved.newest, status, *figures)

    def _only_predict(
        self, old: View, window: View, place: StagePlace
    ) -> tuple[GaussianState, Solved]:
        """Return the newest state as predicted from the last estimate."""
        self._deadline.note_none()
        known = window.newest
        if len(old.times) and not place.is_late:
            dt = float(window.times[-1] - old.times[-1])
            last = replace(old.newest, mean=old.x[-1])
            inputs = self._model.step_inputs(*window.y[-2:])
            known = self._pass.stage.predict(last, dt, inputs=inputs).state
        state = replace(known, mean=window.x[-1].copy())
        lagged = self._pass.look_back(window, window.x, None)
        return state, Solved(None, known, Status.PREDICTED, lagged=lagged)

    def _staying(self, old: View, place: StagePlace, limit: float) -> int:
        """Return how many stages of the window to come keep their factors, as slide.c does."""
        if not self._reuse > 0:
            return 0
        moved = ~(np.isfinite(old.moved) & (old.moved <= limit))[: place.behind]
        k = int(moved.argmax()) if moved.any() else len(moved)
        return max(k - place.drop, 0)

    def _solve(self, window: View, settles: bool) -> Solved:
        """Make the passes of a step."""
        if self._scheme.converges:
            return self._convergence.solve(window)
        if not settles:
            return self._one_pass(window)
        capacity = self.memory.shapes["times"][0]
        can_go_on = lambda: self._deadline.affordable(capacity) >= len(window.times)  # noqa: E731
        return settled(window, self._one_pass, self._slider, can_go_on)

    def _one_pass(self, window: View) -> Solved:
        """Make the linearised window's optimum the trajectory."""
        began = self._deadline.now()
        cost, scales = 0.0, Scales(window.present, np.ones(window.w.shape))
        if self._config.has_losses:
            cost, scales = self._pass.measure(window, window.x_lin, window.w_lin)
        at = window.x_lin, window.w_lin
        settled = SETTLED * self._reuse
        found = self._pass.run(window, -window.prior_deviation, scales, *at, settled)
        if not (np.isfinite(found.length) and np.isfinite(cost)):
            return Solved(found.newest, found.newest.state, Status.NOT_FINITE, 1)
        window.w[:] = found.w
        renewed = slice(found.oldest, None)
        for k in range(len(window.times))[renewed]:
            window.x[k] = self._pass.stage.retract(window.x_lin[k], found.d[k])
        lagged = self._look_back_from(window, found)
        self._deadline.note_pass(len(window.times) - int(window.stayed), began)
        if self._reuse > 0:
            for k, by in list(enumerate(found.moved))[renewed]:
                window.moved[k] = self._judged(window, k, by, found.expected[k], scales.rows[k])
        kkt = max(np.sqrt(found.length), self._pass.largest_excess(window, found.row_std))
        ended = found.held.status, 1, found.cost, kkt
        return Solved(found.newest, found.newest.state, *ended, lagged)

    def _look_back_from(self, window: View, found: Pass) -> tuple[LaggedState, ...]:
        """Look back behind a pass; the window's own states are older before its `oldest`."""
        states = window.x.copy()
        for _, at in told_stages(self._config.lags, len(states)):
            if at < found.oldest:
                states[at] = self._pass.stage.retract(window.x_lin[at], found.d[at])
        return self._pass.look_back(window, states, found)

    def _judged(self, window: View, k: int, by: float, expected: Array, rows: Array) -> float:
        """Return how far a stage is from its linearisation point, squared, as one_pass.c does."""
        if by > self._reuse**2:
            return by
        [off] = self._pass.call["judge"](window.x[k], window.y[k], rows, expected)
        return max(by, float(off[0]) ** 2)

    def _judge(self, window: View, solved: Solved) -> Solved:
        """Say so where chance can hardly explain the cost of a minimum."""
        is_full = len(window.times) > self._config.horizon
        judged = solved.status is Status.SOLVED and (self._scheme.converges or is_full)
        if judged and self._convergence.is_improbable(window, solved.cost):
            return replace(solved, status=Status.IMPROBABLE)
        return solved
