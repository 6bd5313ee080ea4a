"""OSQP through its own Python interface: one Gauss-Newton step of a window as a QP.

Set up once; every window updates the values of P, A, q, l and u in place and starts from
the warm start, as the interface documents. Twice: with OSQP's default settings, and with
settings for this family: the variables are in standard deviations already (``scaling``
off) and ``rho`` is fixed.

- Without bounds all constraints are equalities (``alpha`` 1), so a few iterations do and
  termination is looked at every five.
- With bounds the iterations have to find the rows that are active, and do it slowly: to
  1e-6 they take hundreds to thousands. A rough solution and ``polishing``, which solves the
  equations of the rows that look active, is quicker and, where these are right, exact.
  Tolerance and ``alpha`` are the best of a grid (1e-4, 1e-5; 1 to 1.8) over the bounded problems:
  the quickest with which OSQP solves every window. The best ``rho`` differs by a factor of 30 from
  problem to problem, and an adaptive one misses the active rows more often: of `RHOS` it is
  the one with the fewest iterations on an example. Multipliers of the window before,
  shifted, did not make it quicker.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from models.state_space import StateSpaceModel
from suites.speed.clock import Counted
from suites.speed.contender import RaceOutcome, peer
from suites.speed.qp_step import QpStep
from suites.speed.stagewise import bounded_states
from suites.speed.windows import SpeedWindow

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
TUNED_BOUNDED: Mapping[str, Any] = MappingProxyType(
    {
        **TUNED,
        "eps_abs": 1e-4,
        "eps_rel": 1e-4,
        "alpha": 1.8,
        "check_termination": 10,
        "polishing": True,
    }
)
RHOS = (3.0, 10.0, 30.0, 100.0, 300.0)
"""What to choose ``rho`` from with bounds."""


class Osqp(QpStep):
    """A Gauss-Newton step, solved by OSQP.

    Parameters
    ----------
    settings : of OSQP
    bounded_settings : instead of those, where the model has bounds
    bounded_rhos : where it has, takes the best of them
    call_only : count the compiled linearisation and what OSQP says of its update and its
        solution, in wall time
    """

    def __init__(
        self,
        model: StateSpaceModel,
        example: SpeedWindow,
        settings: Mapping[str, Any],
        bounded_settings: Mapping[str, Any],
        bounded_rhos: Sequence[float] = (),
        call_only: bool = False,
    ) -> None:
        self._call_only = call_only
        osqp, self.version = peer("osqp", "osqp")
        super().__init__(model, example)
        _, q, _, lower, upper = self.numbers()
        self._solver = osqp.OSQP()
        chosen = bounded_settings if bounded_states(model) else settings
        self._solver.setup(self.qp.P, q, self.qp.A, lower, upper, **chosen)
        self._start, self._multipliers = np.zeros(len(q)), np.zeros(len(lower))
        if bounded_states(model) and bounded_rhos:
            rho = min(bounded_rhos, key=lambda rho: self._iterations(rho, example))
            self._solver.update_settings(rho=rho)

    def prepare(self, item: SpeedWindow) -> None:
        """Write the window into the arguments; the warm start is zero."""
        super().prepare(item)
        self._solver.warm_start(x=self._start, y=self._multipliers)

    def solve(self) -> Counted | None:
        """Linearise, update, solve."""
        start = time.perf_counter()
        P, q, A, lower, upper = self.numbers()
        linearised_s = time.perf_counter() - start
        self._solver.update(Px=P, Ax=A, q=q, l=lower, u=upper)
        self._result = self._solver.solve(raise_error=False)
        return Counted(linearised_s + self._result.info.run_time) if self._call_only else None

    def outcome(self) -> RaceOutcome:
        """Unpack the step."""
        return self.found(self._result.info.status_val == 1, self._result.x)

    def _iterations(self, rho: float, window: SpeedWindow) -> int:
        """Return how many iterations a window takes with some rho."""
        self._solver.update_settings(rho=rho)
        self.prepare(window)
        self.solve()
        return int(self._result.info.iter)
