"""IPOPT on this project's own window problem: expanded SX, shifted warm start.

IPOPT's default tolerance. Everything is in standard deviations, so its automatic scaling
of the problem is off; what is not asked for (multipliers of parameters) is not computed. The
barrier, of bounds, begins at 1e-3 instead of 0.1: the warm start is near, and the bounded pen of
15 states takes a sixth of the iterations less; without bounds it changes nothing. With the
Gauss-Newton Hessian, as ``mhe-ipopt`` uses it, or with the exact one.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import casadi as ca
import numpy as np

from mhe.config import WindowConfig
from mhe.reference.window import WindowProblem
from models.state_space import StateSpaceModel
from suites.speed.clock import Counted
from suites.speed.contender import RaceOutcome
from suites.speed.windows import SpeedWindow

OPTIONS: Mapping[str, Any] = {
    "print_time": False,
    "calc_lam_p": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.nlp_scaling_method": "none",
    "ipopt.mu_init": 1e-3,
}


class Ipopt:
    """A window's NLP, solved by IPOPT to its default tolerance.

    Parameters
    ----------
    call_only : count what CasADi says of the solver's own call: CPU time of the process, which has
        one thread, and wall time
    """

    version = f"casadi {version('casadi')}"

    def __init__(
        self,
        model: StateSpaceModel,
        example: SpeedWindow,
        exact_hessian: bool,
        call_only: bool = False,
    ) -> None:
        self._call_only = call_only
        self._problem = WindowProblem.build(model, WindowConfig(horizon=len(example.dt)))
        hessian: dict[str, Any] = {} if exact_hessian else {"hess_lag": self._problem.gauss_newton}
        self._solver = ca.nlpsol(
            "ipopt", "ipopt", self._problem.nlp, {**OPTIONS, **hessian, "record_time": call_only}
        )

    def prepare(self, item: SpeedWindow) -> None:
        """Pack parameters and warm start."""
        self._window = item
        problem, guess = self._problem, item.guess
        parameters = problem.parameters(item.prior, item.measurements, guess.states, item.scale)
        limits = problem.limits(item.measurements, guess.states, item.scale)
        given = {"x0": problem.pack(item.prior, guess), "p": parameters, **limits}
        self._given = {name: ca.DM(value) for name, value in given.items()}

    def solve(self) -> Counted | None:
        """Call the solver."""
        self._solution = self._solver(**self._given)
        if not self._call_only:
            return None
        stats = self._solver.stats()
        return Counted(stats["t_wall_total"], stats["t_proc_total"])

    def outcome(self) -> RaceOutcome:
        """Unpack the solution."""
        variables = np.asarray(self._solution["x"]).ravel()
        window = self._window
        trajectory = self._problem.unpack(variables, window.guess.states, window.scale)
        return RaceOutcome(self._solver.stats()["success"], trajectory.states[-1], trajectory)
