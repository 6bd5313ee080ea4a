"""The reference moving-horizon estimator: every window solved by IPOPT."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from estimation.estimate import Estimate, Window
from estimation.estimator import first_state, late_estimate, remarks
from estimation.function_call import FunctionCall
from estimation.inputs import all_with_inputs, with_inputs, without_readings
from estimation.intervals import check_step
from estimation.kalman_stage import KalmanStage, Prediction, Update, rows_present
from estimation.lagged import LaggedState
from estimation.recording import Measurement
from estimation.rest_detector import RestDetector
from estimation.result import check_rows
from estimation.settings import checked_config
from estimation.status import Status
from mhe.arrival_cost import ARRIVAL_COSTS, Slide, diffuse
from mhe.config import MheIpoptConfig
from mhe.constraint_rows import constrain_function, demanded, inequality_demanded
from mhe.domain import inside
from mhe.look_back import Smoother, look_back
from mhe.reference.window import WindowProblem
from mhe.second_start import cost_limits, is_better, started_beside
from mhe.stage_functions import carry_function, pass_functions
from mhe.trajectory import Trajectory, WindowSolution
from mhe.weights import Weights
from models.arrays import Array
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel

RETURN_STATUS: Mapping[str, Status] = MappingProxyType(
    {
        "Solve_Succeeded": Status.SOLVED,
        "Maximum_Iterations_Exceeded": Status.ITERATION_LIMIT,
        "Maximum_CpuTime_Exceeded": Status.TIME_LIMIT,
        "Maximum_WallTime_Exceeded": Status.TIME_LIMIT,
        "Invalid_Number_Detected": Status.NOT_FINITE,
        "Infeasible_Problem_Detected": Status.INFEASIBLE,
    }
)
"""IPOPT's return status → ours; any other but `STANDS` is `Status.SOLVER_FAILED`."""

STANDS = "Search_Direction_Becomes_Too_Small"
"""IPOPT's word for steps shorter than the tolerance: solved, where its constraints hold as well.

Its own test is on gradients, whose rounding a stiff reading can lift far above any tolerance while
the steps are down to 1e-11 standard deviations: two accelerometers of 7e-5 m/s² on a state that
each alone leaves loose round them to 1e-6.
"""

ANY_MULTIPLIER = 1e20
FEASIBILITY_TOLERANCE = 1e-6
AT_BOUND = 1e-6
"""A row is active so near to its limit: the barrier keeps a state off it."""


@dataclass(frozen=True, eq=False)
class MheState:
    """The window before the next measurement.

    Parameters
    ----------
    prior : of the window's first stage, given all measurements before it
    measurements : the window's stages, at most N + 1
    predictions : per stage, (n_x,): x_k|k-1 when it was the newest
    trajectory : the last solution; None before the first measurement
    newest : the last estimate, or the prior before the first measurement
    rest : what the detector of rest remembers, see `estimation.rest.rest_blocks`
    wait : samples that the next second start waits, see `mhe.second_start`
    """

    prior: GaussianState
    measurements: tuple[Measurement, ...]
    predictions: tuple[Array, ...]
    trajectory: Trajectory | None
    newest: GaussianState
    rest: Array = field(default_factory=lambda: np.zeros(0))
    wait: int = 0


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
        self._carry, self._rows = carry_function(model), constrain_function(model)
        self._cost_limits = cost_limits(self.config.horizon + 1, model.n_r)
        self._problem = WindowProblem.build(model, self.config)
        self._solver = ca.nlpsol("mhe", "ipopt", self._problem.nlp, self._solver_options())

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
        window, trajectory, status, iterations = self._solve_twice(window, guess)
        newest = self._covariance_pass(window, trajectory)[1]
        cost = self._cost(trajectory, window)
        return WindowSolution(trajectory, newest, cost, status, iterations)

    def _attempt(
        self, state: MheState, measurement: Measurement
    ) -> tuple[MheState, Estimate] | None:
        """Slide and solve; None where what is known before solving is not finite."""
        window, guess = self._slide(state, measurement)
        known = guess.states, window.prior.mean, window.prior.covariance
        if not all(np.isfinite(values).all() for values in known):
            return None
        window, trajectory, status, iterations = self._solve_twice(window, guess)
        newest, newest_state = self._covariance_pass(window, trajectory)
        lagged = self._look_back(window, trajectory)
        if not np.isfinite(newest_state.covariance).all():
            status |= Status.NOT_FINITE
        status |= remarks(self.model, newest_state, measurement.y, newest.present)
        window = replace(window, trajectory=trajectory, newest=newest_state)
        times = np.array([m.time_s for m in window.measurements])
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

    def _look_back(self, window: MheState, trajectory: Trajectory) -> tuple[LaggedState, ...]:
        lags = self.config.lags
        if not lags:
            return ()
        updates, predictions = self._forward(window, trajectory)
        covariances = self._smoother.covariances(lags, updates, predictions)
        times = [m.time_s for m in window.measurements]
        return look_back(lags, times, trajectory.states, covariances)

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

    def _solve_twice(
        self, window: MheState, guess: Trajectory
    ) -> tuple[MheState, Trajectory, Status, int]:
        """Solve, and where the minimum is doubtful once more from another start."""
        first, status, iterations = self._solve(window, guess)
        cost, limit = self._cost(first, window), self._cost_limit(window)
        improbable = Status.IMPROBABLE if cost > limit and not status else Status.SOLVED
        if not status and window.wait > 0:
            return replace(window, wait=window.wait - 1), first, improbable, iterations
        doubtful = status & Status.SOLVER_FAILED or improbable
        if not doubtful and (status or not self._is_held_back(first, window)):
            return window, first, status, iterations
        x_0 = started_beside(self.model, window.prior)
        start = self._rolled_out(Trajectory(x_0[None], np.zeros_like(first.noises)), window)
        other, again, more = self._solve(window, start)
        reached = self._cost(other, window)
        if is_better(again, reached, status, cost, is_free=not self._rows.numel_out(0)):
            said = Status.IMPROBABLE if reached > limit and not again else again
            return window, other, said, iterations + more
        is_full = not status and len(window.measurements) > self.config.horizon
        wait = self.config.horizon if is_full else 0
        return replace(window, wait=wait), first, status | improbable, iterations + more

    def _cost_limit(self, window: MheState) -> float:
        """Return the cost that chance explains, see `mhe.second_start`."""
        present = [rows_present(self.model, m.y) for m in window.measurements]
        return float(self._cost_limits[np.count_nonzero(present)])

    def _is_held_back(self, trajectory: Trajectory, window: MheState) -> bool:
        """Return whether a bound or an inequality holds a trajectory."""
        return any(
            (np.asarray(self._rows(x)[0]).ravel()[demanded(self.model, m.y)] > -AT_BOUND).any()
            for x, m in zip(trajectory.states, window.measurements, strict=True)
        )

    def _solve(self, window: MheState, guess: Trajectory) -> tuple[Trajectory, Status, int]:
        problem = self._problem
        # In standard deviations of what is about to be estimated, every tolerance means the same.
        scale = self._covariance_pass(window, guess)[1].std
        parameters = problem.parameters(window.prior, window.measurements, guess.states, scale)
        start = problem.pack(window.prior, guess)
        limits = problem.limits(window.measurements, guess.states, scale)
        solution = self._solver(x0=start, p=parameters, **limits)
        stats = self._solver.stats()
        status = self._status(stats)
        variables = np.asarray(solution["x"]).ravel()
        iterations = int(stats["iter_count"])
        found = problem.unpack(variables, guess.states, scale)
        if status is Status.SOLVED:
            return found, status, iterations
        return self._better(found, guess, window), status, iterations

    def _status(self, stats: Mapping[str, Any]) -> Status:
        said = stats["return_status"]
        if said == STANDS and stats["iterations"]["inf_pr"][-1] <= self.config.tolerance:
            return Status.SOLVED
        return RETURN_STATUS.get(said, Status.SOLVER_FAILED)

    def _better(self, found: Trajectory, guess: Trajectory, window: MheState) -> Trajectory:
        """Return the better of two unfinished trajectories, made to obey the dynamics.

        Less violation of bounds and inequalities comes first, then lower cost.
        """
        candidates = [self._rolled_out(found, window), self._rolled_out(guess, window)]
        finite = [c for c in candidates if np.isfinite(c.states).all()]
        return min(finite or candidates[1:], key=lambda c: self._merit(c, window))

    def _rolled_out(self, trajectory: Trajectory, window: MheState) -> Trajectory:
        states = [trajectory.states[0]]
        pairs = itertools.pairwise(window.measurements)
        for w, (last, here) in zip(trajectory.noises, pairs, strict=True):
            step = here.time_s - last.time_s, *self.model.step_inputs(last.y, here.y)
            states.append(np.asarray(self.model.f(states[-1], w, *step)).ravel())
        return Trajectory(np.array(states), trajectory.noises)

    def _merit(self, trajectory: Trajectory, window: MheState) -> tuple[float, float]:
        model, violation = self.model, 0.0
        for x, measurement in zip(trajectory.states, window.measurements, strict=True):
            g = np.asarray(model.inequality(x)).ravel()
            asked = g[inequality_demanded(model, measurement.y)]
            outside = np.concatenate([model.lower - x, x - model.upper, asked])
            violation = max(violation, float(outside.max(initial=0.0)))
        cost = self._cost(trajectory, window)
        return (violation if violation > FEASIBILITY_TOLERANCE else 0.0, cost)

    def _cost(self, trajectory: Trajectory, window: MheState) -> float:
        problem, no_scale = self._problem, np.ones(self.model.n_x)
        parameters = problem.parameters(
            window.prior, window.measurements, trajectory.states, no_scale
        )
        return float(problem.cost(problem.pack(window.prior, trajectory), parameters))

    def _covariance_pass(
        self, window: MheState, trajectory: Trajectory
    ) -> tuple[Update, GaussianState]:
        """Return the newest update and state of `_forward`."""
        updates, predictions = self._forward(window, trajectory)
        update, gaussian = updates[-1], updates[-1].state
        if self.config.has_losses:  # told is the innovation itself, not its weighed share
            x, y = trajectory.states[-1], window.measurements[-1].y
            first = self._carried(window.prior, x)[0]
            told = self._stage.update(predictions[-1].state if predictions else first, y, x_lin=x)
            v, S = told.innovation, told.innovation_covariance
            update = replace(update, innovation=v, innovation_covariance=S)
        return update, GaussianState(trajectory.states[-1], gaussian.covariance)

    def _forward(
        self, window: MheState, trajectory: Trajectory
    ) -> tuple[list[Update], list[Prediction]]:
        """Run the Kalman stage over the window, linearised at the trajectory."""
        updates, predictions = list[Update](), list[Prediction]()
        gaussian, away = self._carried(window.prior, trajectory.states[0])
        times = [m.time_s for m in window.measurements]
        for k, measurement in enumerate(window.measurements):
            if k:
                x, w = trajectory.states[k - 1], trajectory.noises[k - 1]
                scale, _ = self._weights.noises(w)
                dt = times[k] - times[k - 1]
                inputs = self.model.step_inputs(window.measurements[k - 1].y, measurement.y)
                predictions.append(self._stage.predict(gaussian, dt, x, w, scale, inputs=inputs))
                gaussian = predictions[-1].state
            x = trajectory.states[k]
            rows, _ = self._weights.readings(x, measurement.y)
            y = measurement.y
            updates.append(self._stage.update(gaussian, y, rows, x, None if k else away))
            gaussian = updates[-1].state
        return updates, predictions

    def _carried(self, prior: GaussianState, x: Array) -> tuple[GaussianState, Array]:
        """Return a prior along the tangent space at x, and its mean's deviation from x."""
        d = self._stage.difference(x, prior.mean)
        if self._carry is None:
            return prior, -d
        J = np.asarray(self._carry(prior.mean, d, x))
        return GaussianState(prior.mean, J @ prior.covariance @ J.T), -J @ d

    def _solver_options(self) -> dict[str, Any]:
        options: dict[str, Any] = {
            "print_time": False,
            "error_on_fail": False,
            "show_eval_warnings": False,  # the status says it
            "calc_lam_p": False,  # not used, and not finite at Δt = 0
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "ipopt.tol": self.config.tolerance,
            # The barrier keeps a weakly active state off its bound by about the root of it.
            "ipopt.compl_inf_tol": 1e-4 * self.config.tolerance,
            # Steps are in standard deviations, as those that end `mhe`; multipliers need not stand.
            "ipopt.tiny_step_tol": self.config.tolerance,
            "ipopt.tiny_step_y_tol": ANY_MULTIPLIER,
            "ipopt.nlp_scaling_method": "none",  # everything is in standard deviations
            "ipopt.max_iter": self.config.max_iterations,
            "ipopt.acceptable_iter": 0,  # solved means converged, not almost
            "ipopt.bound_relax_factor": 0.0,
        }
        if self.config.hessian == "gauss-newton":
            options["hess_lag"] = self._problem.gauss_newton
        if self.config.deadline_s is not None:
            options["ipopt.max_wall_time"] = self.config.deadline_s
        return options | {f"ipopt.{name}": value for name, value in self.config.ipopt.items()}
