"""IPOPT as the reference for windows, carried on until it really stands at a minimum.

With the Gauss-Newton Hessian IPOPT finds the minimum that a Gauss-Newton method finds; with
the exact one, indefinite far from it, it may leave for another. But where residuals are
large the full Gauss-Newton step is too long even at the minimum. Halving helps as long as the
cost can judge, that is to about 1e-4 standard deviations; there IPOPT ends. A second run with
the exact Hessian, from where the first one ended, takes it the rest of the way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from mhe.trajectory import Trajectory, WindowSolution
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.optimum.cases import WindowCase
from suites.optimum.newton_step import NewtonCheck

LONGEST_LEFT = 1e-7
"""Newton step left, standard deviations, above which a reference is not accurate enough: a
tenth of what is allowed between newest states. To the cost it means ½ (1e-7)², nothing."""

NO_HIGHER = 1e-9
"""Relative rise in cost that the second run may show; above, it has left the minimum."""


@dataclass(frozen=True)
class Reference:
    """Where IPOPT ended.

    Parameters
    ----------
    solution : its own
    newton_length : of the Newton step left, see `suites.optimum.newton_step.NewtonStep`
    runs : how many it needed, 1 or 2
    """

    solution: WindowSolution
    newton_length: float
    runs: int


class IpoptReference:
    """IPOPT, in one or two runs."""

    def __init__(self, model: StateSpaceModel, settings: MheIpoptConfig) -> None:
        self._model, self._settings = model, settings
        self._first, self._check = MheIpopt(model, settings), NewtonCheck(model, settings)

    def solve(self, case: WindowCase) -> Reference:
        """Solve a window of the model, at most as long as the horizon of the settings."""
        first = self._first.solve(case.prior, case.measurements, case.guess)
        length = self.newton_length(case, first.trajectory, first.newest.std)
        if length <= LONGEST_LEFT:
            return Reference(first, length, 1)
        last = self._second.solve(case.prior, case.measurements, first.trajectory)
        both = replace(last, iterations=first.iterations + last.iterations)
        if not last.cost - first.cost <= NO_HIGHER * max(1.0, abs(first.cost)):
            return Reference(first, length, 2)
        length = self.newton_length(case, last.trajectory, last.newest.std)
        return Reference(both, length, 2)

    def newton_length(self, case: WindowCase, trajectory: Trajectory, std: Array) -> float:
        """Return how long a Newton step from a trajectory is, infinite where there is none.

        Parameters
        ----------
        std : (n_x,) of the newest state
        """
        if not (np.isfinite(trajectory.states).all() and np.isfinite(std).all()):
            return np.inf
        length = self._check.step(case.prior, case.measurements, trajectory, std).length
        return length if np.isfinite(length) else np.inf

    @cached_property
    def _second(self) -> MheIpopt:
        return MheIpopt(self._model, replace(self._settings, hessian="exact"))
