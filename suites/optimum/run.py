"""A window solver against IPOPT: the same windows from the same starts, one row each.

Whether both are in the same minimum is decided by cost alone, so that an unfinished solution
cannot pass for another minimum. Whether IPOPT is good enough to be compared with is measured
by a Newton step from where it ended (`suites.optimum.newton_step`), whatever it says itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Protocol

import numpy as np

from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig, MheIpoptConfig
from mhe.realtime import Mhe
from mhe.trajectory import Trajectory, WindowSolution
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from suites.optimum.cases import WindowCase, WindowKey, window_case
from suites.optimum.newton_step import AT_BOUND
from suites.optimum.reference import LONGEST_LEFT, IpoptReference

NEWEST_LIMIT = 1e-6
"""How far the newest states may be apart in the same minimum, posterior standard deviations."""
COST_LIMIT = 1e-9
"""How far their costs may be apart, relative."""
SAME_COST = 1e-6
"""Costs farther apart than this, relative, are those of different minima."""

SETTINGS = MheConfig(tolerance=1e-10, max_iterations=5000)
"""Of the solver that is compared. Where Gauss-Newton converges slowly, the way left is up to a
hundred times as long as its next step; 5000 passes take half a second, so that the number of
passes ends nothing."""
IPOPT_SETTINGS = MheIpoptConfig(tolerance=1e-10, max_iterations=500)
"""Of each run of IPOPT; more iterations than these, some seconds, leave it where it stands."""

SAME, ABOVE, BELOW, IPOPT_FAILED = "same", "above", "below", "ipopt failed"
VERDICTS = (SAME, ABOVE, BELOW, IPOPT_FAILED)


class WindowSolver(Protocol):
    """What solves a window from a given start."""

    def solve(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> WindowSolution:
        """Return the solution."""
        ...


SolverMaker = Callable[[StateSpaceModel, MheConfig], WindowSolver]
SOLVERS: Mapping[str, SolverMaker] = MappingProxyType({Mhe.name: Mhe})
"""What can be compared, by name."""


@dataclass(frozen=True)
class WindowRow:
    """What became of one window.

    Parameters
    ----------
    key : of the window
    verdict : one of `VERDICTS`, about the solver's cost against IPOPT's
    status, ipopt_status : of the solvers
    cost, ipopt_cost : of their solutions
    relative : (cost - ipopt_cost) / max(1, |ipopt_cost|)
    newest_distance : between the newest states, posterior standard deviations of the state
        that is farthest
    newton_length, ipopt_newton_length : of the Newton step left, see
        `suites.optimum.newton_step.NewtonStep`
    at_bounds, ipopt_at_bounds : number of states of the solutions that stand at a bound
    iterations, ipopt_iterations : of the solvers
    ipopt_runs : 2 where IPOPT was carried on with the exact Hessian
    """

    key: WindowKey
    verdict: str
    status: Status
    ipopt_status: Status
    cost: float
    ipopt_cost: float
    relative: float
    newest_distance: float
    newton_length: float
    ipopt_newton_length: float
    at_bounds: int
    ipopt_at_bounds: int
    iterations: int
    ipopt_iterations: int
    ipopt_runs: int

    @property
    def holds(self) -> bool:
        """Whether newest state and cost are as near as they must be; of the same minimum only."""
        return self.newest_distance <= NEWEST_LIMIT and abs(self.relative) <= COST_LIMIT

    @property
    def reason(self) -> str:
        """Why it does not hold, by what is left of both; empty where it does."""
        left, its = self.newton_length, self.ipopt_newton_length
        if self.verdict == IPOPT_FAILED:
            return f"IPOPT stopped short, {its:.0e} left: {self.ipopt_status.label}"
        hidden = np.sqrt(2 * np.finfo(float).eps * abs(self.cost))
        if self.verdict == SAME:
            if self.holds:
                return ""
            why = f"a cost of {self.cost:.0e} hides steps below {hidden:.0e}"
            return f"{left:.0e} left: " + (why if left <= hidden else self.status.label)
        if not left <= NEWEST_LIMIT:
            return f"mhe stopped short, {left:.0e} left: {self.status.label}"
        where = [f"{n} states at bounds" for n in (self.at_bounds, self.ipopt_at_bounds)]
        return "two minima" + (f": {where[0]}, IPOPT {where[1]}" if self.at_bounds else "")


def compare(key: WindowKey, solver: str = Mhe.name) -> WindowRow:
    """Solve a window both ways.

    Parameters
    ----------
    solver : one of `SOLVERS`
    """
    case = window_case(key)
    return compared(case, *_built(solver, case.model, key.horizon))


def compared(case: WindowCase, solver: WindowSolver, reference: IpoptReference) -> WindowRow:
    """Solve a window both ways, with solvers made for its model and horizon."""
    ours = solver.solve(case.prior, case.measurements, case.guess)
    ipopt = reference.solve(case)
    its = ipopt.solution
    apart = case.model.difference(ours.trajectory.states[-1], its.trajectory.states[-1])
    relative = (ours.cost - its.cost) / max(1.0, abs(its.cost))
    return WindowRow(
        case.key,
        judged(relative, ipopt.newton_length),
        ours.status,
        its.status,
        ours.cost,
        its.cost,
        relative,
        float(np.max(np.abs(apart.full().ravel()) / its.newest.std)),
        reference.newton_length(case, ours.trajectory, its.newest.std),
        ipopt.newton_length,
        _at_bounds(case.model, ours.trajectory, its.newest.std),
        _at_bounds(case.model, its.trajectory, its.newest.std),
        ours.iterations,
        its.iterations,
        ipopt.runs,
    )


def judged(relative: float, ipopt_newton_length: float) -> str:
    """Return one of `VERDICTS`; a cost that is not finite is above."""
    if not ipopt_newton_length <= LONGEST_LEFT:
        return IPOPT_FAILED
    if relative < -SAME_COST:
        return BELOW
    return SAME if relative <= SAME_COST else ABOVE


def _at_bounds(model: StateSpaceModel, trajectory: Trajectory, std: Array) -> int:
    slack = np.minimum(trajectory.states - model.lower, model.upper - trajectory.states)
    return int((slack <= AT_BOUND * std).sum())


@lru_cache(maxsize=2)
def _built(
    solver: str, model: StateSpaceModel, horizon: int
) -> tuple[WindowSolver, IpoptReference]:
    """Return solver and reference; windows of one model and horizon come in a row."""
    ours, its = replace(SETTINGS, horizon=horizon), replace(IPOPT_SETTINGS, horizon=horizon)
    return SOLVERS[solver](model, ours), IpoptReference(model, its)
