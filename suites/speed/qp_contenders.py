"""Clarabel, PIQP and QPALM: one Gauss-Newton step of a window, as `suites.speed.osqp_contender`.

Each is set up once and given the numbers of every window in place. Tolerances are the
defaults of Clarabel and PIQP (1e-8); QPALM is given 1e-7, as its 1e-4 is too rough here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from benchmark.bound_call import BoundCall
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.speed.contender import RaceOutcome, knows_only_bounds, peer
from suites.speed.gauss_newton_qp import GaussNewtonQp, qp_arguments
from suites.speed.stagewise import bounded_states, trajectory_of
from suites.speed.windows import SpeedWindow

QPALM_TOLERANCE = 1e-7


class QpStep:
    """What the contenders have in common: the numbers of the QP, and the step they find.

    The first `n_equal` rows of A are equalities, those behind them bounds.
    """

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        knows_only_bounds(model)
        self.qp = GaussNewtonQp.build(model, len(example.dt))
        self.n_equal = len(example.dt) * model.n_x
        self._numbers = BoundCall(self.qp.numbers)
        self.write(example)
        P, _, A, _, _ = self.numbers()
        self.qp.P.data, self.qp.A.data = P.copy(), A.copy()

    def write(self, window: SpeedWindow) -> None:
        """Write a window into the arguments."""
        self._window = window
        for argument, value in zip(self._numbers.arguments, qp_arguments(window), strict=True):
            argument[:] = value

    def numbers(self) -> tuple[Array, ...]:
        """Return the values of P (upper triangle), q, A, l and u at the warm start."""
        self._numbers.evaluate()
        return tuple(self._numbers.results)

    def outcome(self, solved: bool, variables: Array) -> RaceOutcome:
        """Return the step as an outcome."""
        trajectory = trajectory_of(np.asarray(variables, dtype=float), self._window)
        return RaceOutcome(solved, trajectory.states[-1], trajectory)


class Clarabel:
    """Interior point; every bound that is there is a row of its own: A z + s = b, s ≥ 0."""

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        clarabel, self.version = peer("clarabel", "clarabel")
        self._step = step = QpStep(model, example)
        _, q, _, lower, upper = step.numbers()
        self._upper = step.n_equal + np.flatnonzero(np.isfinite(upper[step.n_equal :]))
        self._lower = step.n_equal + np.flatnonzero(np.isfinite(lower[step.n_equal :]))
        equal, n_bounds = np.arange(step.n_equal), len(self._upper) + len(self._lower)
        rows = np.concatenate([equal, self._upper, self._lower])
        A, self._place = _rows(step.qp.A, rows)
        below = np.repeat([1.0, -1.0], [step.n_equal + len(self._upper), len(self._lower)])
        self._sign = below[A.indices]
        A.data = A.data * self._sign
        cones = [clarabel.ZeroConeT(step.n_equal)]
        if n_bounds:
            cones.append(clarabel.NonnegativeConeT(n_bounds))
        settings = clarabel.DefaultSettings()
        settings.verbose, settings.max_threads = False, 1
        # Data may be updated only where nothing was taken out of it.
        settings.presolve_enable = settings.input_sparse_dropzeros = False
        settings.chordal_decomposition_enable = False
        b = self._b(lower, upper)
        self._solver = clarabel.DefaultSolver(step.qp.P, q, A, b, cones, settings)
        self._solved = clarabel.SolverStatus.Solved

    def prepare(self, item: SpeedWindow) -> None:
        """Write the window into the arguments; there is no warm start."""
        self._step.write(item)

    def solve(self) -> None:
        """Linearise, update, solve."""
        P, q, A, lower, upper = self._step.numbers()
        values = A[self._place] * self._sign
        self._solver.update(P=P, q=q, A=values, b=self._b(lower, upper))
        self._solution = self._solver.solve()

    def outcome(self) -> RaceOutcome:
        """Unpack the step."""
        return self._step.outcome(self._solution.status == self._solved, self._solution.x)

    def _b(self, lower: Array, upper: Array) -> Array:
        return np.concatenate(
            [upper[: self._step.n_equal], upper[self._upper], -lower[self._lower]]
        )


class Piqp:
    """Proximal interior point, with its factorisation for problems in stages.

    Parameters
    ----------
    kkt_solver : name of a factorisation
    """

    def __init__(
        self, model: StateSpaceModel, example: SpeedWindow, kkt_solver: str = "sparse_multistage"
    ) -> None:
        piqp, self.version = peer("piqp", "piqp")
        self._step = step = QpStep(model, example)
        _, q, _, lower, upper = step.numbers()
        self._A, self._place = _rows(step.qp.A, np.arange(step.n_equal))
        # A bound's row has one entry, of 1: the variable that it bounds.
        self._bounded = step.qp.A.tocsr()[step.n_equal :].indices
        self._x_l, self._x_u = np.full(len(q), -np.inf), np.full(len(q), np.inf)
        self._solver = piqp.SparseSolver()
        self._solver.settings.kkt_solver = getattr(piqp.KKTSolver, kkt_solver)
        self._solver.settings.verbose = False
        self._bound(lower, upper)
        b = lower[: step.n_equal]
        bounds = {"x_l": self._x_l, "x_u": self._x_u} if bounded_states(model) else {}
        self._is_bounded = bool(bounds)
        self._solver.setup(step.qp.P, q, self._A, b, **bounds)
        self._solved = piqp.PIQP_SOLVED

    def prepare(self, item: SpeedWindow) -> None:
        """Write the window into the arguments; there is no warm start."""
        self._step.write(item)

    def solve(self) -> None:
        """Linearise, update, solve."""
        P, q, A, lower, upper = self._step.numbers()
        self._step.qp.P.data[:] = P
        self._A.data[:] = A[self._place]
        given: dict[str, Any] = {"P": self._step.qp.P, "A": self._A, "c": q}
        if self._is_bounded:
            self._bound(lower, upper)
            given |= {"x_l": self._x_l, "x_u": self._x_u}
        self._solver.update(b=lower[: self._step.n_equal], **given)
        self._status = self._solver.solve()

    def outcome(self) -> RaceOutcome:
        """Unpack the step."""
        return self._step.outcome(self._status == self._solved, self._solver.result.x)

    def _bound(self, lower: Array, upper: Array) -> None:
        self._x_l[self._bounded] = lower[self._step.n_equal :]
        self._x_u[self._bounded] = upper[self._step.n_equal :]


class Qpalm:
    """Proximal augmented Lagrangian; in this thread, whose clock would not see another."""

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        qpalm, self.version = peer("qpalm", "qpalm")
        self._step = step = QpStep(model, example)
        _, q, _, lower, upper = step.numbers()
        data = qpalm.Data(len(q), len(lower))
        data.Q = step.qp.P  # of which it keeps the upper triangle
        data.A, data.q, data.bmin, data.bmax = step.qp.A, q, lower, upper
        settings = qpalm.Settings()
        settings.verbose = 0
        settings.eps_abs = settings.eps_rel = QPALM_TOLERANCE
        self._solver = qpalm.Solver(data, settings)
        self._start, self._multipliers = np.zeros(len(q)), np.zeros(len(lower))
        self._solved = qpalm.Info.SOLVED

    def prepare(self, item: SpeedWindow) -> None:
        """Write the window into the arguments; the warm start is zero."""
        self._step.write(item)

    def solve(self) -> None:
        """Linearise, update, solve."""
        P, q, A, lower, upper = self._step.numbers()
        self._solver.update_Q_A(P, A)
        self._solver.update_q(q)
        self._solver.update_bounds(lower, upper)
        self._solver.warm_start(self._start, self._multipliers)
        self._solver.solve(asynchronous=False, suppress_interrupt=True)

    def outcome(self) -> RaceOutcome:
        """Unpack the step."""
        solved = self._solver.info.status_val == self._solved
        return self._step.outcome(solved, self._solver.solution.x)


def _rows(A: sp.csc_matrix, rows: NDArray[np.int_]) -> tuple[sp.csc_matrix, NDArray[np.int_]]:
    """Return some rows of a matrix, and where their values stand among those of the whole."""
    places = sp.csc_matrix((1 + np.arange(A.nnz), A.indices, A.indptr), A.shape)[rows].tocsc()
    places.sort_indices()  # a row that is taken twice comes out of order
    place = places.data.astype(int) - 1
    return sp.csc_matrix((A.data[place], places.indices, places.indptr), places.shape), place
