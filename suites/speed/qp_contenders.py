"""Clarabel, PIQP and QPALM: one Gauss-Newton step of a window, as `suites.speed.osqp_contender`.

Each is set up once and given the numbers of every window in place. Tolerances are the
defaults of Clarabel and PIQP (1e-8); QPALM is given 1e-7, as its 1e-4 is too rough here.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.speed.contender import RaceOutcome, peer
from suites.speed.qp_step import QpStep
from suites.speed.stagewise import bounded_states
from suites.speed.windows import SpeedWindow

QPALM_TOLERANCE = 1e-7


class Clarabel(QpStep):
    """Interior point; every bound that is there is a row of its own: A z + s = b, s ≥ 0."""

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        clarabel, self.version = peer("clarabel", "clarabel")
        super().__init__(model, example)
        _, q, _, lower, upper = self.numbers()
        self._upper = self.n_equal + np.flatnonzero(np.isfinite(upper[self.n_equal :]))
        self._lower = self.n_equal + np.flatnonzero(np.isfinite(lower[self.n_equal :]))
        equal, n_bounds = np.arange(self.n_equal), len(self._upper) + len(self._lower)
        rows = np.concatenate([equal, self._upper, self._lower])
        A, self._place = _rows(self.qp.A, rows)
        below = np.repeat([1.0, -1.0], [self.n_equal + len(self._upper), len(self._lower)])
        self._sign = below[A.indices]
        A.data = A.data * self._sign
        cones = [clarabel.ZeroConeT(self.n_equal)]
        if n_bounds:
            cones.append(clarabel.NonnegativeConeT(n_bounds))
        settings = clarabel.DefaultSettings()
        settings.verbose, settings.max_threads = False, 1
        # Data may be updated only where nothing was taken out of it.
        settings.presolve_enable = settings.input_sparse_dropzeros = False
        settings.chordal_decomposition_enable = False
        b = self._b(lower, upper)
        self._solver = clarabel.DefaultSolver(self.qp.P, q, A, b, cones, settings)
        self._solved = clarabel.SolverStatus.Solved

    def solve(self) -> None:
        """Linearise, update, solve."""
        P, q, A, lower, upper = self.numbers()
        values = A[self._place] * self._sign
        self._solver.update(P=P, q=q, A=values, b=self._b(lower, upper))
        self._solution = self._solver.solve()

    def outcome(self) -> RaceOutcome:
        """Unpack the step."""
        return self.found(self._solution.status == self._solved, self._solution.x)

    def _b(self, lower: Array, upper: Array) -> Array:
        return np.concatenate([upper[: self.n_equal], upper[self._upper], -lower[self._lower]])


class Piqp(QpStep):
    """Proximal interior point, with its factorisation for problems in stages."""

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        piqp, self.version = peer("piqp", "piqp")
        super().__init__(model, example)
        _, q, _, lower, upper = self.numbers()
        self._A, self._place = _rows(self.qp.A, np.arange(self.n_equal))
        # A bound's row has one entry, of 1: the variable that it bounds.
        self._bounded = self.qp.A.tocsr()[self.n_equal :].indices
        self._x_l, self._x_u = np.full(len(q), -np.inf), np.full(len(q), np.inf)
        self._solver = piqp.SparseSolver()
        self._solver.settings.kkt_solver = piqp.KKTSolver.sparse_multistage
        self._solver.settings.verbose = False
        self._bound(lower, upper)
        bounds = {"x_l": self._x_l, "x_u": self._x_u} if bounded_states(model) else {}
        self._solver.setup(self.qp.P, q, self._A, lower[: self.n_equal], **bounds)
        self._bounds = bounds
        self._solved = piqp.PIQP_SOLVED

    def solve(self) -> None:
        """Linearise, update, solve."""
        P, q, A, lower, upper = self.numbers()
        self.qp.P.data[:] = P
        self._A.data[:] = A[self._place]
        self._bound(lower, upper)
        b = lower[: self.n_equal]
        self._solver.update(P=self.qp.P, c=q, A=self._A, b=b, **self._bounds)
        self._status = self._solver.solve()

    def outcome(self) -> RaceOutcome:
        """Unpack the step."""
        return self.found(self._status == self._solved, self._solver.result.x)

    def _bound(self, lower: Array, upper: Array) -> None:
        self._x_l[self._bounded] = lower[self.n_equal :]
        self._x_u[self._bounded] = upper[self.n_equal :]


class Qpalm(QpStep):
    """Proximal augmented Lagrangian; in this thread, whose clock would not see another."""

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        qpalm, self.version = peer("qpalm", "qpalm")
        super().__init__(model, example)
        _, q, _, lower, upper = self.numbers()
        data = qpalm.Data(len(q), len(lower))
        data.Q = self.qp.P  # of which it keeps the upper triangle
        data.A, data.q, data.bmin, data.bmax = self.qp.A, q, lower, upper
        settings = qpalm.Settings()
        settings.verbose = 0
        settings.eps_abs = settings.eps_rel = QPALM_TOLERANCE
        self._solver = qpalm.Solver(data, settings)
        self._start, self._multipliers = np.zeros(len(q)), np.zeros(len(lower))
        self._solved = qpalm.Info.SOLVED

    def solve(self) -> None:
        """Linearise, update, solve."""
        P, q, A, lower, upper = self.numbers()
        self._solver.update_Q_A(P, A)
        self._solver.update_q(q)
        self._solver.update_bounds(lower, upper)
        self._solver.warm_start(self._start, self._multipliers)
        self._solver.solve(asynchronous=False, suppress_interrupt=True)

    def outcome(self) -> RaceOutcome:
        """Unpack the step."""
        solved = self._solver.info.status_val == self._solved
        return self.found(solved, self._solver.solution.x)


def _rows(A: sp.csc_matrix, rows: NDArray[np.int_]) -> tuple[sp.csc_matrix, NDArray[np.int_]]:
    """Return some rows of a matrix, and where their values stand among those of the whole."""
    places = sp.csc_matrix((1 + np.arange(A.nnz), A.indices, A.indptr), A.shape)[rows].tocsc()
    places.sort_indices()  # a row that is taken twice comes out of order
    place = places.data.astype(int) - 1
    return sp.csc_matrix((A.data[place], places.indices, places.indptr), places.shape), place
