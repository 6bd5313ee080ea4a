"""The reference moving-horizon estimator: every window solved by IPOPT."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estimation.estimate import Estimate, Window
from estimation.estimator import first_state, late_estimate, remarks
from estimation.exclusive import Exclusive, in_turn
from estimation.function_call import FunctionCall
from estimation.inputs import all_with_inputs, with_inputs, without_readings
from estimation.intervals import check_step
from estimation.kalman_stage import KalmanStage, rows_present
from estimation.recording import Measurement
from estimation.rest_detector import RestDetector
from estimation.result import check_rows
from estimation.settings import checked_config
from estimation.status import Status
from mhe.arrival_cost import diffuse
from mhe.config import MheIpoptConfig
from mhe.late import StagePlace, place_of, readings_there
from mhe.look_back import Smoother, look_back
from mhe.reference.forward_pass import ForwardPass
from mhe.reference.ipopt_solver import IpoptSolver
from mhe.reference.sliding import Slider
from mhe.reference.state import MheState
from mhe.stage_functions import pass_functions
from mhe.trajectory import Trajectory, WindowSolution
from mhe.weights import Weights
from models.arrays import Array
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel


class MheIpopt(Exclusive):
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
        super().__init__(model, self.config)
        self._stage, self._weights = KalmanStage(model), Weights(model, self.config)
        self._rest, functions = RestDetector(model), pass_functions(model, *self._stage.functions)
        self._smoother = Smoother({f.name(): FunctionCall(f) for f in functions})
        self._pass = ForwardPass(model, self.config, self._stage, self._weights)
        self._solver = IpoptSolver(model, self.config, self._pass)
        self._slider = Slider(model, self.config, self._stage, self._weights)

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

    @in_turn
    def step(self, state: MheState, measurement: Measurement) -> tuple[MheState, Estimate]:
        """Slide the window onto the measurement and solve it."""
        check_rows(self.model, np.asarray(measurement.time_s), measurement.y)
        place = self._place(state, measurement)
        if place.at < 0:
            return state, self._refused(state, Status.LATE)
        rest, measurement = self._taken(state, place, measurement)
        y, state = measurement.y, replace(state, rest=rest)
        found = self._attempt(state, place, measurement)
        if found is not None and Status.NOT_FINITE not in found[1].status:
            return found
        if place.is_late:
            return state, self._refused(state, Status.NOT_FINITE)
        # A reading so far off that its square overflows would spoil the window for N
        # steps: the instant stays, its readings go.
        nothing = Measurement(measurement.time_s, without_readings(self.model, y))
        found = self._attempt(state, place, nothing)
        if found is not None:
            status = found[1].status & ~Status.NO_READING | Status.NOT_FINITE
            return found[0], replace(found[1], status=status)
        # Where not even the prediction is finite the window begins anew, with the last estimate.
        empty = MheState(state.newest, (), (), None, state.newest, rest)
        anew = self._attempt(empty, self._place(empty, nothing), nothing)
        assert anew is not None
        return anew[0], replace(anew[1], status=anew[1].status | Status.NOT_FINITE)

    def _place(self, state: MheState, measurement: Measurement) -> StagePlace:
        """Return where a measurement goes; a step of no length that the model has is refused."""
        times, model = [m.time_s for m in state.measurements], self.model
        newest_s = times[-1] if times else measurement.time_s
        check_step(model, *sorted((newest_s, measurement.time_s)))
        rows = [rows_present(model, m.y) for m in state.measurements]
        there = [readings_there(model, present) for present in rows]
        capacity = self.config.horizon + 1
        return place_of(times, there, capacity, measurement.time_s, measurement.y)

    def _refused(self, state: MheState, status: Status) -> Estimate:
        """Return what is said of a late measurement that changes nothing."""
        late = late_estimate(self.model, state.measurements[-1].time_s, state.newest)
        return replace(late, status=status)

    def _taken(
        self, state: MheState, place: StagePlace, measurement: Measurement
    ) -> tuple[Array, Measurement]:
        """Return what the detector of rest remembers, and a measurement with all its inputs."""
        last, before = state.measurements[-1:], None
        if last:
            known = state.measurements[place.before] if place.is_late else last[0]
            before = known.y[self.model.n_y :]
        y = with_inputs(self.model, before, measurement.y)
        if place.is_late:
            return state.rest, replace(measurement, y=y)
        dt = measurement.time_s - last[0].time_s if last else 0.0
        rest, y = self._rest.step(state.rest, dt, y)
        return rest, replace(measurement, y=y)

    @in_turn
    def solve(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> WindowSolution:
        """Solve one window of at most N + 1 stages from a given start."""
        rows = all_with_inputs(self.model, measurements)
        window = MheState(prior, rows, (), None, prior)
        window, trajectory, status, iterations = self._solver.solve(window, guess)
        known = self._pass.run(window, trajectory)[0][-1].state
        newest = GaussianState(trajectory.states[-1], known.covariance)
        cost = self._solver.cost(trajectory, window)
        return WindowSolution(trajectory, newest, cost, status, iterations)

    def _attempt(
        self, state: MheState, place: StagePlace, measurement: Measurement
    ) -> tuple[MheState, Estimate] | None:
        """Slide and solve; None where what is known before solving is not finite."""
        window, guess = self._slider.slide(state, place, measurement)
        known = guess.states, window.prior.mean, window.prior.covariance
        if not all(np.isfinite(values).all() for values in known):
            return None
        window, trajectory, status, iterations = self._solver.solve(window, guess)
        updates, predictions = self._pass.run(window, trajectory)
        steps, own = (updates, predictions), rows_present(self.model, measurement.y)
        newest_state = GaussianState(trajectory.states[-1], updates[-1].state.covariance)
        told = self._pass.told(window, trajectory, *steps, place.at)
        S = told.innovation_covariance
        if place.joins:  # the others have their noise alone, as where they are missing
            S = np.where(np.outer(own, own), S, np.diag(self.model.noise_std**2))
        times = np.array([m.time_s for m in window.measurements])
        covariances = self._smoother.covariances(self.config.lags, updates, predictions)
        lagged = look_back(self.config.lags, times, trajectory.states, covariances)
        if not np.isfinite(newest_state.covariance).all():
            status |= Status.NOT_FINITE
        status |= remarks(self.model, newest_state, measurement.y, own)
        window = replace(window, trajectory=trajectory, newest=newest_state)
        estimate = Estimate(
            window.measurements[-1].time_s,
            newest_state,
            status,
            np.where(own, told.innovation, np.nan),
            S,
            iterations,
            Window(times, trajectory.states),
            lagged=lagged,
        )
        return window, estimate
