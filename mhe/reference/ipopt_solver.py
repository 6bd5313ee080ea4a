"""A window solved by IPOPT, and once more from another start where the minimum is doubtful."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from estimation.kalman_stage import rows_present
from estimation.status import Status
from mhe.config import MheIpoptConfig
from mhe.constraint_rows import constrain_function, demanded, inequality_demanded
from mhe.reference.forward_pass import ForwardPass
from mhe.reference.state import MheState
from mhe.reference.window import WindowProblem
from mhe.second_start import cost_limits, is_better, started_beside
from mhe.trajectory import Trajectory, driven
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


def status_of(stats: Mapping[str, Any], tolerance: float) -> Status:
    """Return how IPOPT ended, by what CasADi says of it."""
    said = stats["return_status"]
    if said == STANDS and stats["iterations"]["inf_pr"][-1] <= tolerance:
        return Status.SOLVED
    return RETURN_STATUS.get(said, Status.SOLVER_FAILED)


class IpoptSolver:
    """Solves windows.

    Parameters
    ----------
    passes : of the estimator, for the standard deviations that a window is scaled by
    """

    def __init__(self, model: StateSpaceModel, config: MheIpoptConfig, passes: ForwardPass) -> None:
        self._model, self._config, self._pass = model, config, passes
        self._rows = constrain_function(model)
        self._cost_limits = cost_limits(config.horizon + 1, model.n_r)
        self._problem = WindowProblem.build(model, config)
        self._solver = ca.nlpsol("mhe", "ipopt", self._problem.nlp, self._options())

    def solve(
        self, window: MheState, guess: Trajectory
    ) -> tuple[MheState, Trajectory, Status, int]:
        """Solve, and where the minimum is doubtful once more from another start."""
        first, status, iterations = self._once(window, guess)
        cost, limit = self.cost(first, window), self._cost_limit(window)
        improbable = Status.IMPROBABLE if cost > limit and not status else Status.SOLVED
        if not status and window.wait > 0:
            return replace(window, wait=window.wait - 1), first, improbable, iterations
        doubtful = status & Status.SOLVER_FAILED or improbable
        if not doubtful and (status or not self._is_held_back(first, window)):
            return window, first, status, iterations
        x_0 = started_beside(self._model, window.prior)
        start = driven(self._model, x_0, np.zeros_like(first.noises), window.measurements)
        other, again, more = self._once(window, start)
        reached = self.cost(other, window)
        if is_better(again, reached, status, cost, is_free=not self._rows.numel_out(0)):
            said = Status.IMPROBABLE if reached > limit and not again else again
            return window, other, said, iterations + more
        is_full = not status and len(window.measurements) > self._config.horizon
        wait = self._config.horizon if is_full else 0
        return replace(window, wait=wait), first, status | improbable, iterations + more

    def _cost_limit(self, window: MheState) -> float:
        """Return the cost that chance explains, see `mhe.second_start`."""
        present = [rows_present(self._model, m.y) for m in window.measurements]
        return float(self._cost_limits[np.count_nonzero(present)])

    def _is_held_back(self, trajectory: Trajectory, window: MheState) -> bool:
        """Return whether a bound or an inequality holds a trajectory."""
        return any(
            (np.asarray(self._rows(x)[0]).ravel()[demanded(self._model, m.y)] > -AT_BOUND).any()
            for x, m in zip(trajectory.states, window.measurements, strict=True)
        )

    def _once(self, window: MheState, guess: Trajectory) -> tuple[Trajectory, Status, int]:
        problem = self._problem
        # In standard deviations of what is about to be estimated, every tolerance means the same.
        scale = self._pass.run(window, guess)[0][-1].state.std
        parameters = problem.parameters(window.prior, window.measurements, guess.states, scale)
        start = problem.pack(window.prior, guess)
        limits = problem.limits(window.measurements, guess.states, scale)
        solution = self._solver(x0=start, p=parameters, **limits)
        stats = self._solver.stats()
        status = status_of(stats, self._config.tolerance)
        variables = np.asarray(solution["x"]).ravel()
        iterations = int(stats["iter_count"])
        found = problem.unpack(variables, guess.states, scale)
        if status is Status.SOLVED:
            return found, status, iterations
        return self._better(found, guess, window), status, iterations

    def _better(self, found: Trajectory, guess: Trajectory, window: MheState) -> Trajectory:
        """Return the better of two unfinished trajectories, made to obey the dynamics.

        Less violation of bounds and inequalities comes first, then lower cost.
        """
        candidates = [
            driven(self._model, each.states[0], each.noises, window.measurements)
            for each in (found, guess)
        ]
        finite = [c for c in candidates if np.isfinite(c.states).all()]
        return min(finite or candidates[1:], key=lambda c: self._merit(c, window))

    def _merit(self, trajectory: Trajectory, window: MheState) -> tuple[float, float]:
        model, violation = self._model, 0.0
        for x, measurement in zip(trajectory.states, window.measurements, strict=True):
            g = np.asarray(model.inequality(x)).ravel()
            asked = g[inequality_demanded(model, measurement.y)]
            outside = np.concatenate([model.lower - x, x - model.upper, asked])
            violation = max(violation, float(outside.max(initial=0.0)))
        cost = self.cost(trajectory, window)
        return (violation if violation > FEASIBILITY_TOLERANCE else 0.0, cost)

    def cost(self, trajectory: Trajectory, window: MheState) -> float:
        """Return ½ the sum of squares of a window's trajectory."""
        problem, no_scale = self._problem, np.ones(self._model.n_x)
        parameters = problem.parameters(
            window.prior, window.measurements, trajectory.states, no_scale
        )
        return float(problem.cost(problem.pack(window.prior, trajectory), parameters))

    def _options(self) -> dict[str, Any]:
        options: dict[str, Any] = {
            "print_time": False,
            "error_on_fail": False,
            "show_eval_warnings": False,  # the status says it
            "calc_lam_p": False,  # not used, and not finite at Δt = 0
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "ipopt.tol": self._config.tolerance,
            # The barrier keeps a weakly active state off its bound by about the root of it.
            "ipopt.compl_inf_tol": 1e-4 * self._config.tolerance,
            # Steps are in standard deviations, as those that end `mhe`; multipliers need not stand.
            "ipopt.tiny_step_tol": self._config.tolerance,
            "ipopt.tiny_step_y_tol": ANY_MULTIPLIER,
            "ipopt.nlp_scaling_method": "none",  # everything is in standard deviations
            "ipopt.max_iter": self._config.max_iterations,
            "ipopt.acceptable_iter": 0,  # solved means converged, not almost
            "ipopt.bound_relax_factor": 0.0,
        }
        if self._config.hessian == "gauss-newton":
            options["hess_lag"] = self._problem.gauss_newton
        if self._config.deadline_s is not None:
            options["ipopt.max_wall_time"] = self._config.deadline_s
        return options | {f"ipopt.{name}": value for name, value in self._config.ipopt.items()}
