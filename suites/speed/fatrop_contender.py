"""fatrop, an interior-point solver for optimal-control problems, through CasADi.

As its interface documents: variables and constraints in the order of the stages with
gap-closing constraints x_{k+1} - f(x_k, w_k), ``structure_detection: auto``, expanded SX,
its default tolerance. The interface has no option for a Gauss-Newton Hessian; CasADi's
``cache`` option hands it one all the same, which takes it half the iterations.

Bounds are bounds on the variables. With them the tolerance is 1e-7: at the default of 1e-8
it wanders about the turntable's optimum for hundreds of iterations, and fails in half of its
windows, within 1e-5 standard deviations of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from models.state_space import StateSpaceModel
from suites.speed.contender import ContenderAbsentError, RaceOutcome, knows_only_bounds
from suites.speed.stagewise import (
    StagewiseProblem,
    bounded_states,
    stagewise_bounds,
    stagewise_parameters,
    trajectory_of,
)
from suites.speed.windows import SpeedWindow

BOUNDED_OPTIONS: Mapping[str, Any] = MappingProxyType({"fatrop.tolerance": 1e-7})


class Fatrop:
    """A window's NLP, solved by fatrop to its default tolerance."""

    version = f"casadi {version('casadi')}"

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        if not ca.has_nlpsol("fatrop"):
            raise ContenderAbsentError("this CasADi comes without fatrop")
        knows_only_bounds(model)
        stages = StagewiseProblem.build(model, len(example.dt))
        nlp = {"x": stages.x, "p": stages.p, "f": ca.sumsqr(stages.residual) / 2, "g": stages.gaps}
        options: dict[str, Any] = {
            "structure_detection": "auto",
            "equality": [True] * stages.gaps.numel(),
            "expand": True,
            "print_time": False,
            "calc_lam_p": False,
            "fatrop.print_level": 0,
            "cache": {"nlp_hess_l": _gauss_newton(nlp, stages.residual)},
        }
        if bounded_states(model):
            options |= BOUNDED_OPTIONS
        self._start = ca.DM.zeros(stages.x.numel())
        self._zero = ca.DM.zeros(stages.gaps.numel())
        self._solver = ca.nlpsol("fatrop", "fatrop", nlp, options)

    def prepare(self, item: SpeedWindow) -> None:
        """Pack parameters and bounds; the warm start is zero."""
        lower, upper = stagewise_bounds(item)
        given = {"p": stagewise_parameters(item), "lbx": lower, "ubx": upper}
        fixed = {"x0": self._start, "lbg": self._zero, "ubg": self._zero}
        self._window = item
        self._given = {**fixed, **{name: ca.DM(value) for name, value in given.items()}}

    def solve(self) -> None:
        """Call the solver."""
        self._solution = self._solver(**self._given)

    def outcome(self) -> RaceOutcome:
        """Unpack the solution."""
        trajectory = trajectory_of(np.asarray(self._solution["x"]).ravel(), self._window)
        return RaceOutcome(self._solver.stats()["success"], trajectory.states[-1], trajectory)


def _gauss_newton(nlp: dict[str, ca.SX], residual: ca.SX) -> ca.Function:
    """Return gradient and, for the Hessian, JᵀJ of the Lagrangian, in the form fatrop calls."""
    weight, multipliers = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", nlp["g"].numel())
    J = ca.jacobian(residual, nlp["x"])
    lagrangian = weight * nlp["f"] + ca.dot(multipliers, nlp["g"])
    return ca.Function(
        "nlp_hess_l",
        [nlp["x"], nlp["p"], weight, multipliers],
        [ca.gradient(lagrangian, nlp["x"]), weight * (J.T @ J)],
        ["x", "p", "lam_f", "lam_g"],
        ["grad_gamma_x", "hess_gamma_x_x"],
        {"cse": True},
    )
