"""The real-time moving-horizon estimators: Gauss-Newton passes of the Kalman stage.

A Gauss-Newton step of the window problem (`mhe.reference.window`) is a pass of the EKF's own stage
over the window, linearised at the current trajectory, and a smoother's pass back
(`mhe.stage_functions`). Both run in compiled C, mhe/compiled/*.c; without a compiler the same
stages run in CasADi's virtual machine (`mhe.interpreted.loop`).

``mhe-rti`` makes one pass per sample and takes its full step. ``mhe`` makes passes until a
step is shorter than the tolerance, in standard deviations; a backtracking line search
keeps the window's cost from ever rising, so it cannot diverge.

References
----------
Bell (1994), The iterated Kalman smoother as a Gauss-Newton method, SIAM J. Optim. 4(3).
Diehl, Bock, Schlöder (2005), A real-time iteration scheme for nonlinear optimization in
optimal feedback control, SIAM J. Control Optim. 43(5).
Särkkä, Svensson (2020), Levenberg-Marquardt and line-search extended Kalman smoothers,
ICASSP.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from estimation.chosen import chosen
from estimation.collect import Batches
from estimation.estimate import Estimate, EstimateHistory, Window
from estimation.exclusive import Exclusive, in_turn
from estimation.inputs import all_with_inputs
from estimation.intervals import check_step
from estimation.recording import Measurement
from estimation.result import ResultReader
from estimation.settings import checked_config
from mhe.compiled.loop import CompiledWindow
from mhe.config import Clock, MheConfig, MheRtiConfig, RealTimeConfig, check_stages
from mhe.interpreted.loop import InterpretedWindow
from mhe.sparse_qp.fallback import Fallback
from mhe.trajectory import Trajectory, WindowSolution
from mhe.window_memory import WindowState, first_window, packed_window, window_memory
from models.arrays import Array
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel


class RealTimeMhe(Exclusive):
    """What both estimators share: slide, solve, fall back, read the result.

    Parameters
    ----------
    config : its settings; their scheme says which passes are made
    clock : of `WindowConfig.deadline_s`; None is the machine's own
    """

    name: str

    def __init__(self, model: StateSpaceModel, config: RealTimeConfig, clock: Clock | None) -> None:
        super().__init__(model, config, clock=clock)
        self.model, self.config, self.lags = model, config, config.lags
        memory = window_memory(model, self.config.horizon + 1)
        self.engine = chosen(
            lambda: CompiledWindow(model, self.config, memory, clock),
            lambda: InterpretedWindow(model, self.config, memory, clock),
        )
        self._reader = ResultReader(model, config.lags)
        self._batches = Batches(self.name, self._reader, memory, self._take)
        self._fallback = Fallback(model, self.config, memory, self._reader.layout)
        self._times, self._x = memory.slices["times"].start, memory.slices["x"].start

    def init(self, prior: Prior | None = None) -> WindowState:
        """Return the state before the first measurement; see `ekf_baseline.ekf.Ekf.init`."""
        return first_window(self.model, self.config, self.engine.memory, prior)

    @in_turn
    def step(self, state: WindowState, measurement: Measurement) -> tuple[WindowState, Estimate]:
        """Slide the window onto the measurement and solve it."""
        if self.model.interval_s is not None and (n := int(state.memory.item(0))):
            newest_s = state.memory.item(self._times + n - 1)
            check_step(self.model, *sorted((newest_s, measurement.time_s)))
        memory, result = self.engine.step(state.memory, measurement.time_s, measurement.y)
        if self._fallback.is_needed(self._reader.status_of(result)):
            memory, result = self._fallback.solve(memory, result)
        return self.told(memory, result)

    def told(self, memory: Array, result: Array) -> tuple[WindowState, Estimate]:
        """Return the state and the estimate of a step of the engine that is solved."""
        count, n_x = int(memory.item(0)), self.model.n_x
        times = memory[self._times : self._times + count]
        states = memory[self._x : self._x + count * n_x].reshape(count, n_x)
        return WindowState(memory), self._reader.estimate(result, Window(times, states))

    @in_turn
    def batch(
        self,
        state: WindowState,
        time_s: Array,
        y: Array,
        *,
        covariances: bool = False,
        on_progress: Callable[[int], None] | None = None,
    ) -> tuple[WindowState, EstimateHistory]:
        """Take n measurements in compiled calls; the same as n steps.

        Parameters
        ----------
        time_s, y : (n,), (n, n_row), as of `estimation.recording.Recording.stacked`
        covariances, on_progress : see `estimation.estimator.run`
        """
        memory, history = self._batches.take(state.memory, time_s, y, covariances, on_progress)
        return WindowState(memory), history

    def _take(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        memory, results = self.engine.batch(given, time_s, y)
        statuses = map(self._reader.status_of, results)
        if any(self._fallback.is_needed(status) for status in statuses):
            return self._take_by_steps(given, time_s, y)
        return memory, results

    def _take_by_steps(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        """Take measurements one by one: what one step falls back on, the next begins with."""
        memory, results = given, []
        for t, readings in zip(time_s, y, strict=True):
            memory, result = self.engine.step(memory, float(t), readings)
            if self._fallback.is_needed(self._reader.status_of(result)):
                memory, result = self._fallback.solve(memory, result)
            results.append(result)
        return memory, np.array(results)


class MheRti(RealTimeMhe):
    """Real-time iteration: one Gauss-Newton pass per sample.

    Parameters
    ----------
    clock : of `MheRtiConfig.deadline_s`; the machine's own by default
    """

    name = "mhe-rti"

    def __init__(
        self,
        model: StateSpaceModel,
        config: MheRtiConfig | None = None,
        *,
        clock: Clock | None = None,
    ) -> None:
        super().__init__(model, checked_config(self.name, config, MheRtiConfig), clock)


class Mhe(RealTimeMhe):
    """Passes to convergence, with a line search.

    Parameters
    ----------
    clock : of `MheConfig.deadline_s`; the machine's own by default
    """

    name = "mhe"

    def __init__(
        self,
        model: StateSpaceModel,
        config: MheConfig | None = None,
        *,
        clock: Clock | None = None,
    ) -> None:
        super().__init__(model, checked_config(self.name, config, MheConfig), clock)

    @in_turn
    def solve(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> WindowSolution:
        """Solve one window of at most N + 1 stages from a given start, to convergence.

        Parameters
        ----------
        guess : the first state and the noises; the states behind follow from them

        Raises
        ------
        InputError
            If there are none, or more than N + 1 measurements.
        """
        layout, count = self.engine.memory, len(measurements)
        check_stages(count, self.config.horizon)
        rows = all_with_inputs(self.model, measurements)
        memory = packed_window(self.model, self.config.horizon + 1, prior, rows, guess).memory
        memory, result = self.engine.solve(memory)
        if self._fallback.is_needed(self._reader.status_of(result)):
            memory, result = self._fallback.solve(memory, result)
        estimate = self._reader.estimate(result)
        found = Trajectory(
            layout.view(memory, "x")[:count].copy(), layout.view(memory, "w")[: count - 1].copy()
        )
        cost = float(self._reader.layout.view(result, "cost"))
        return WindowSolution(found, estimate.state, cost, estimate.status, estimate.iterations)
