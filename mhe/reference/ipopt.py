"""The reference moving-horizon estimator: every window solved by IPOPT."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.estimate import Estimate, Window
from estimation.estimator import first_state, late_estimate, remarks
from estimation.function_call import FunctionCall
from estimation.inputs import all_with_inputs, with_inputs, without_readings
from estimation.intervals import check_step
from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from estimation.rest_detector import RestDetector
from estimation.result import check_rows
from estimation.settings import checked_config
from estimation.status import Status
from mhe.arrival_cost import ARRIVAL_COSTS, Slide, diffuse
from mhe.config import MheIpoptConfig
from mhe.domain import inside
from mhe.look_back import Smoother, look_back
from mhe.reference.forward_pass import ForwardPass
from mhe.reference.ipopt_solver import IpoptSolver
from mhe.reference.state import MheState
from mhe.stage_functions import pass_functions
from mhe.trajectory import Trajectory, WindowSolution
from mhe.weights import Weights
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel


class MheIpopt:
    """Moving-horizon estimator that solves every window to convergence with IPOPT.

    At the start the window grows from one stage. The covariance of the newest
    state is the Gauss-Newton one: a pass of the Kalman stage over the window,
    linearised at the optimum; bounds that are active do not narrow it.

    References
    ----------
    Rao, Rawlings, Mayne (2003), Constrained state estimation for nonlinear
    discrete-time systems, IEEE Trans. Automatic Control 48(2).
    """

    name = "mhe-ipopt"

    def __init__(self, model: StateSpaceModel, config: MheIpoptConfig | None = None) -> None:
        self.model = model
        self.config = checked_config(self.name, config, MheIpoptConfig)
        self._stage, self._weights = KalmanStage(model), Weights(model, self.config)
        self._rest, functions = RestDetector(model), pass_functions(model, *self._stage.functions)
        self._smoother = Smoother({f.name(): FunctionCall(f) for f in functions})
        self._pass = ForwardPass(model, self.config, self._stage, self._weights)
        self._solver = IpoptSolver(model, self.config, self._pass)

    @property
    def lags(self) -> tuple[int, ...]:
        """See `mhe.config.WindowConfig`."""
        return self.config.lags

    def init(self, prior: Prior | None = None) -> MheState:
        """Return the state before the first measurement; see `ekf_baseline.ekf.Ekf.init`."""
        prior = first_state(self.model, prior)
        if self.config.arrival_cost == "none":
            prior = diffuse(prior)
        return MheState(prior, (), (), None, prior, self._rest.first())

    def step(self, state: MheState, measurement: Measurement) -> tuple[MheState, Estimate]:
        """Slide the window onto the measurement and solve it."""
        check_rows(self.model, np.asarray(measurement.time_s), measurement.y)
        if state.measurements and measurement.time_s < state.measurements[-1].time_s:
            newest_s = state.measurements[-1].time_s
            return state, late_estimate(self.model, newest_s, state.newest)
        last = state.measurements[-1] if state.measurements else None
        dt = 0.0 if last is None else measurement.time_s - last.time_s
        check_step(self.model, None if last is None else last.time_s, measurement.time_s)
        before = None if last is None else last.y[self.model.n_y :]
        y = with_inputs(self.model, before, measurement.y)
        rest, y = self._rest.step(state.rest, dt, y)
        state, measurement = replace(state, rest=rest), replace(measurement, y=y)
        found = self._attempt(state, measurement)
        if found is not None and Status.NOT_FINITE not in found[1].status:
            return found
        # A reading so far off that its square overflows would spoil the window for N
        # steps: the instant stays, its readings go.
        nothing = Measurement(measurement.time_s, without_readings(self.model, y))
        found = self._attempt(state, nothing)
        if found is not None:
            status = found[1].status & ~Status.NO_READING | Status.NOT_FINITE
            return found[0], replace(found[1], status=status)
        # Where not even the prediction is finite the window begins anew, with the last estimate.
        anew = self._attempt(MheState(state.newest, (), (), None, state.newest, rest), nothing)
        assert anew is not None
        return anew[0], replace(anew[1], status=anew[1].status | Status.NOT_FINITE)

    def solve(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> WindowSolution:
        """Solve one window of at most N + 1 stages from a given start."""
        rows = all_with_inputs(self.model, measurements)
        window = MheState(prior, rows, (), None, prior)
        window, trajectory, status, iterations = self._solver.solve(window, guess)
        newest = self._pass.newest(window, trajectory, *self._pass.run(window, trajectory))[1]
        cost = self._solver.cost(trajectory, window)
        return WindowSolution(trajectory, newest, cost, status, iterations)

    def _attempt(
        self, state: MheState, measurement: Measurement
    ) -> tuple[MheState, Estimate] | None:
        """Slide and solve; None where what is known before solving is not finite."""
        window, guess = self._slide(state, measurement)
        known = guess.states, window.prior.mean, window.prior.covariance
        if not all(np.isfinite(values).all() for values in known):
            return None
        window, trajectory, status, iterations = self._solver.solve(window, guess)
        updates, predictions = self._pass.run(window, trajectory)
        newest, newest_state = self._pass.newest(window, trajectory, updates, predictions)
        times = np.array([m.time_s for m in window.measurements])
        covariances = self._smoother.covariances(self.config.lags, updates, predictions)
        lagged = look_back(self.config.lags, times, trajectory.states, covariances)
        if not np.isfinite(newest_state.covariance).all():
            status |= Status.NOT_FINITE
        status |= remarks(self.model, newest_state, measurement.y, newest.present)
        window = replace(window, trajectory=trajectory, newest=newest_state)
        estimate = Estimate(
            measurement.time_s,
            newest_state,
            status,
            np.where(newest.present, newest.innovation, np.nan),
            newest.innovation_covariance,
            iterations,
            Window(times, trajectory.states),
            lagged=lagged,
        )
        return window, estimate

    def _slide(self, state: MheState, measurement: Measurement) -> tuple[MheState, Trajectory]:
        """Append a stage, drop the oldest where the window is full, shift the solution."""
        model = self.model
        if state.trajectory is None:
            predicted = inside(model, state.prior.mean)
            guess = Trajectory(predicted[None, :], np.zeros((0, model.n_w)))
            first = replace(state, measurements=(measurement,), predictions=(predicted,))
            return first, guess
        dt = measurement.time_s - state.measurements[-1].time_s
        no_noise = np.zeros(model.n_w)
        inputs = model.step_inputs(state.measurements[-1].y, measurement.y)
        reached = np.asarray(model.f(state.trajectory.states[-1], no_noise, dt, *inputs)).ravel()
        predicted = inside(model, reached)
        guess = Trajectory(
            np.vstack([state.trajectory.states, predicted]),
            np.vstack([state.trajectory.noises, no_noise]),
        )
        measurements = (*state.measurements, measurement)
        predictions = (*state.predictions, predicted)
        prior = state.prior
        if len(measurements) > self.config.horizon + 1:
            carry = ARRIVAL_COSTS[self.config.arrival_cost]
            rows, _ = self._weights.readings(guess.states[0], measurements[0].y)
            noises, _ = self._weights.noises(guess.noises[0])
            ends = measurements[0], measurements[1]
            slide = Slide(prior, *ends, guess, predictions[1], rows, noises)
            prior = carry(self._stage, slide)
            measurements, predictions = measurements[1:], predictions[1:]
            guess = Trajectory(guess.states[1:], guess.noises[1:])
        moved = replace(
            state,
            prior=prior,
            measurements=measurements,
            predictions=predictions,
            trajectory=None,
        )
        return moved, guess
