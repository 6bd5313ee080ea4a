"""fatrop, an interior-point solver for optimal-control problems, through CasADi.

As its interface documents: variables and constraints in the order of the stages with
gap-closing constraints x_{k+1} - f(x_k, w_k), ``structure_detection: auto``, expanded SX,
its default tolerance. The interface has no option for a Gauss-Newton Hessian; CasADi's
``cache`` option hands it one all the same, which takes it half the iterations.
"""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import casadi as ca
import numpy as np

from benchmark.speed.contender import ContenderAbsentError, Outcome
from benchmark.speed.stagewise import StagewiseProblem, stagewise_parameters, trajectory_of
from benchmark.speed.windows import SpeedWindow
from models.state_space import StateSpaceModel


class Fatrop:
    """A window's NLP, solved by fatrop to its default tolerance."""

    version = f"casadi {version('casadi')}"

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        if not ca.has_nlpsol("fatrop"):
            raise ContenderAbsentError("this CasADi comes without fatrop")
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
        self._start = ca.DM.zeros(stages.x.numel())
        self._zero = ca.DM.zeros(stages.gaps.numel())
        self._solver = ca.nlpsol("fatrop", "fatrop", nlp, options)

    def prepare(self, item: SpeedWindow) -> None:
        """Pack the parameters; the warm start is zero."""
        self._window, self._parameters = item, ca.DM(stagewise_parameters(item))

    def solve(self) -> None:
        """Call the solver."""
        zero = self._zero
        self._solution = self._solver(x0=self._start, p=self._parameters, lbg=zero, ubg=zero)

    def outcome(self) -> Outcome:
        """Unpack the solution."""
        trajectory = trajectory_of(np.asarray(self._solution["x"]).ravel(), self._window)
        return Outcome(self._solver.stats()["success"], trajectory.states[-1], trajectory)


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
