"""A window with constraints to convergence, by Gauss-Newton steps that OSQP solves.

Every step is the optimum of the linearised window (`mhe.sparse_qp.osqp_window`), taken whole,
states and noises alike: a state that does not yet follow from its noises is a defect of the next
linearisation. Where a step turns out longer than the one before it, it is halved.

Slow, and independent of the compiled passes and of IPOPT's barrier: bounds are met to
rounding, a weakly active row is active.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from estimation.inputs import all_with_inputs
from estimation.kalman_stage import without_gaps
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig, RealTimeConfig, check_stages
from mhe.constraint_rows import demanded
from mhe.sparse_qp.osqp_window import OsqpWindow, QpSolution, factor_of
from mhe.trajectory import Trajectory, WindowSolution, driven
from mhe.weights import Weights
from mhe.window_memory import Scales
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

SHORTEST_PART = 1e-3
"""Of a step; where it still does not help, nothing does."""


@dataclass(frozen=True, eq=False)
class ConstrainedSolution:
    """A window's optimum, with the multipliers of its constraint rows.

    Parameters
    ----------
    solution : what every window solver returns
    multipliers : (n, n_c), not negative
    length : of the last step, in standard deviations
    qp_iterations : of OSQP, all steps together
    """

    solution: WindowSolution
    multipliers: Array
    length: float
    qp_iterations: int


@dataclass(frozen=True, eq=False)
class _QpPoint:
    """A window at a trajectory; a `mhe.sparse_qp.linearised_window.WindowStages`."""

    times: Array
    y: Array
    x: Array
    w: Array
    prior: GaussianState


class SequentialQp:
    """Solves windows of a model to convergence; see `mhe.realtime.Mhe.solve`.

    Parameters
    ----------
    model : with or without constraints
    config : horizon, tolerance, losses and most iterations
    """

    def __init__(self, model: StateSpaceModel, config: RealTimeConfig | None = None) -> None:
        self.model, self.config = model, config or MheConfig()
        self._weights, self._windows = Weights(model, self.config), dict[int, OsqpWindow]()

    def solve(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> WindowSolution:
        """Solve one window of at most N + 1 stages from a given start."""
        return self.solve_window(prior, measurements, guess).solution

    def solve_window(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> ConstrainedSolution:
        """Solve one window; also say with which multipliers.

        Parameters
        ----------
        guess : the first state and the noises; the states behind follow from them

        Raises
        ------
        InputError
            If there are none, or more than N + 1 measurements.
        """
        n, scheme = len(measurements), self.config.scheme
        measurements = all_with_inputs(self.model, measurements)
        check_stages(n, self.config.horizon)
        if n not in self._windows:
            self._windows[n] = OsqpWindow(self.model, n)
        qp = self._windows[n]
        qp.forget()
        point, part, iterations = self._start(prior, measurements, guess), 1.0, 1
        found = self._step(qp, point, measurements)
        qp_iterations, status = found.iterations, found.status
        while found.solved and found.length > scheme.tolerance:
            if iterations >= scheme.max_iterations or part < SHORTEST_PART:
                limited = iterations >= scheme.max_iterations
                status = Status.ITERATION_LIMIT if limited else Status.SOLVER_FAILED
                break
            there = self._moved(qp, point, found, part)
            following = self._step(qp, there, measurements)
            iterations, qp_iterations = iterations + 1, qp_iterations + following.iterations
            if following.solved and following.length < found.length:
                point, found, part = there, following, 1.0
            else:
                part, status = part / 2, following.status
        if found.solved:
            point = self._moved(qp, point, found, 1.0)
        newest = GaussianState(point.x[-1], found.newest)
        trajectory = Trajectory(point.x, point.w)
        cost = self._cost(qp, point, measurements)
        solution = WindowSolution(trajectory, newest, cost, status, iterations)
        return ConstrainedSolution(solution, found.multipliers, found.length, qp_iterations)

    def _start(
        self, prior: GaussianState, measurements: tuple[Measurement, ...], guess: Trajectory
    ) -> _QpPoint:
        times = np.array([m.time_s for m in measurements])
        y = np.array([without_gaps(m.y) for m in measurements])
        start = driven(self.model, guess.states[0], guess.noises, measurements)
        return _QpPoint(times, y, start.states, guess.noises, prior)

    def _step(
        self, qp: OsqpWindow, point: _QpPoint, measurements: tuple[Measurement, ...]
    ) -> QpSolution:
        """Linearise and solve."""
        rows = [
            self._weights.readings(x, m.y)[0] for x, m in zip(point.x, measurements, strict=True)
        ]
        noises = [self._weights.noises(w)[0] for w in point.w]
        scales = Scales(np.array(rows), np.array(noises).reshape(point.w.shape))
        d = qp.lineariser.difference(point.x[0], point.prior.mean)
        asked = np.array([demanded(self.model, m.y) for m in measurements])
        return qp.run(point, d, scales, asked)

    @staticmethod
    def _moved(qp: OsqpWindow, point: _QpPoint, found: QpSolution, part: float) -> _QpPoint:
        """Return the point a part of the step further on."""
        retract = qp.lineariser.stage.retract
        x = [retract(x, part * step) for x, step in zip(point.x, found.d, strict=True)]
        return replace(point, x=np.array(x), w=point.w + part * (found.w - point.w))

    def _cost(
        self, qp: OsqpWindow, point: _QpPoint, measurements: tuple[Measurement, ...]
    ) -> float:
        away = qp.lineariser.difference(point.x[0], point.prior.mean)
        L = factor_of(point.prior.covariance)
        if np.isnan(L).any():
            return float("nan")
        cost = float(np.sum(solve_triangular(L, away, lower=True) ** 2)) / 2
        cost += sum(self._weights.noises(w)[1] for w in point.w)
        return cost + sum(
            self._weights.readings(x, m.y)[1] for x, m in zip(point.x, measurements, strict=True)
        )
