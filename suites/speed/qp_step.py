"""What all that solve a Gauss-Newton step as a QP have in common."""

from __future__ import annotations

import numpy as np

from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.bound_call import BoundCall
from suites.speed.contender import RaceOutcome, knows_only_bounds
from suites.speed.gauss_newton_qp import GaussNewtonQp, qp_arguments
from suites.speed.stagewise import trajectory_of
from suites.speed.windows import SpeedWindow


class QpStep:
    """The numbers of a window's QP, and the step of its solution.

    The first `n_equal` rows of A are equalities, those behind them bounds. There is no warm start
    but zero: variables are steps from the window's.
    """

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        knows_only_bounds(model)
        self.qp = GaussNewtonQp.build(model, len(example.dt))
        self.n_equal = len(example.dt) * model.n_x
        self._numbers = BoundCall(self.qp.numbers)
        QpStep.prepare(self, example)
        P, _, A, _, _ = self.numbers()
        self.qp.P.data, self.qp.A.data = P.copy(), A.copy()

    def prepare(self, item: SpeedWindow) -> None:
        """Write the window into the arguments."""
        self._window = item
        for argument, value in zip(self._numbers.arguments, qp_arguments(item), strict=True):
            argument[:] = value

    def numbers(self) -> tuple[Array, ...]:
        """Return the values of P (upper triangle), q, A, l and u at the warm start."""
        self._numbers.evaluate()
        return tuple(self._numbers.results)

    def found(self, solved: bool, variables: Array) -> RaceOutcome:
        """Return the step that the variables are as an outcome."""
        trajectory = trajectory_of(np.asarray(variables, dtype=float), self._window)
        return RaceOutcome(solved, trajectory.states[-1], trajectory)
