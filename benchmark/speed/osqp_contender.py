"""OSQP through its own Python interface: one Gauss-Newton step of a window as a QP.

Set up once; every window updates the values of P, A, q, l and u in place and starts from
the warm start, as the interface documents. Twice: with OSQP's default settings, and with
settings for this family: the variables are in standard deviations already (``scaling``
off), all constraints are equalities (``alpha`` 1, fixed ``rho``), so a few iterations do
and termination is looked at every five.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmark.speed.bound_call import BoundCall
from benchmark.speed.contender import Outcome, peer
from benchmark.speed.gauss_newton_qp import GaussNewtonQp, qp_arguments
from benchmark.speed.stagewise import trajectory_of
from benchmark.speed.windows import SpeedWindow
from models.state_space import StateSpaceModel

DEFAULT: Mapping[str, Any] = MappingProxyType({"verbose": False})
TUNED: Mapping[str, Any] = MappingProxyType(
    {
        **DEFAULT,
        "eps_abs": 1e-6,
        "eps_rel": 1e-6,
        "scaling": 0,
        "alpha": 1.0,
        "rho": 10.0,
        "adaptive_rho": False,
        "check_termination": 5,
    }
)


class Osqp:
    """A Gauss-Newton step, solved by OSQP."""

    def __init__(
        self, model: StateSpaceModel, example: SpeedWindow, settings: Mapping[str, Any]
    ) -> None:
        osqp, self.version = peer("osqp", "osqp")
        qp = GaussNewtonQp.build(model, len(example.dt))
        self._numbers = BoundCall(qp.numbers)
        self._write(example)
        self._numbers.evaluate()
        P, q, A, b = self._numbers.results
        qp.P.data, qp.A.data = P.copy(), A.copy()
        self._solver = osqp.OSQP()
        self._solver.setup(qp.P, q, qp.A, b, b, **settings)
        self._start, self._multipliers = np.zeros(len(q)), np.zeros(len(b))

    def prepare(self, item: SpeedWindow) -> None:
        """Write the window into the arguments; the warm start is zero."""
        self._window = item
        self._write(item)
        self._solver.warm_start(x=self._start, y=self._multipliers)

    def solve(self) -> None:
        """Linearise, update, solve."""
        self._numbers.evaluate()
        P, q, A, b = self._numbers.results
        self._solver.update(Px=P, Ax=A, q=q, l=b, u=b)
        self._result = self._solver.solve(raise_error=False)

    def outcome(self) -> Outcome:
        """Unpack the step."""
        trajectory = trajectory_of(self._result.x, self._window)
        return Outcome(self._result.info.status_val == 1, trajectory.states[-1], trajectory)

    def _write(self, window: SpeedWindow) -> None:
        for argument, value in zip(self._numbers.arguments, qp_arguments(window), strict=True):
            argument[:] = value
