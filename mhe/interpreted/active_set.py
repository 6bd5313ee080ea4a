"""The multipliers of a linearised window's rows: a dual active-set method.

With multipliers ν ≥ 0 of rows g + Cᵀδ ≤ 0, the optimum of the linearised window is the free one
with the impulses C ν on it, and the rows' values there are

    g + Cᵀδ_s = r - M ν,   M = Cᵀ H⁻¹ C

r are the values at the free optimum, H is the window's Hessian, which nobody forms: a column
of M is one sweep of an impulse through the factors of the free pass (`propagate`, `absorb` in
`mhe.stage_functions`). So constraints need no pass of their own, and the free pass has told the
covariance, which active rows do not narrow.

1. Begin with the rows that were active before, without those whose multipliers would be negative.
2. Take the row that is exceeded most, in standard deviations. Raise its multiplier, the others
   following so that their rows stay met, until it is met itself. Where one of the others
   would fall below zero its row goes out of the set first.
3. Repeat until no row is exceeded by more than `EXCESS`.

The dual cost grows with every turn, so no set comes twice and the method ends. A row that
cannot be met beside those in the set means that no state meets all (`Status.INFEASIBLE`).

mhe/compiled/active_set.c is the same in C. There the multipliers are refined by what their rows are
still off after the pass back (`MET`, `ENOUGH`). And a descent's later passes begin with the set of
the pass before, held as readings without noise in the pass itself; only where that set turns out
wrong is it looked for again.

References
----------
Goldfarb, Idnani (1983), A numerically stable dual method for solving strictly convex quadratic
programs, Math. Programming 27.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, solve_triangular

from estimation.status import Status
from mhe.rules import DEPENDENT, EXCESS, MOST_CHANGES
from models.arrays import Array


@dataclass(frozen=True, eq=False)
class Held:
    """The rows that hold a linearised window, and their multipliers (n_rows,), zero elsewhere."""

    multipliers: Array
    active: NDArray[np.bool_]
    status: Status


class ActiveSet:
    """The method on rows whose responses are asked for one at a time.

    Parameters
    ----------
    values : (n_rows,) r; -inf for a row that is not demanded
    std : (n_rows,) what counts as one standard deviation of a row
    respond : row → its column (n_rows,) of M
    capacity : most rows that may be held
    """

    def __init__(
        self, values: Array, std: Array, respond: Callable[[int], Array], capacity: int
    ) -> None:
        self._free, self._std, self._respond, self._capacity = values, std, respond, capacity
        self._set: list[int] = []
        self._columns: list[Array] = []
        self._factor = np.zeros((0, 0))
        self._nu = np.zeros(0)

    def find(self, active: NDArray[np.bool_]) -> Held:
        """Return the multipliers, beginning with rows (n_rows,) that were active before."""
        self._begin(active & np.isfinite(self._free))
        status, turns = Status.SOLVED, 0
        values = self._values()
        while (p := self._most_exceeded(values)) is not None:
            if len(self._set) == self._capacity or turns == MOST_CHANGES * len(values):
                status = Status.SOLVER_FAILED
                break
            status = self._raise(p, float(values[p]))
            if status is not Status.SOLVED:
                break
            turns += 1
            values = self._values()
        multipliers, held = np.zeros(len(values)), np.zeros(len(values), dtype=bool)
        multipliers[self._set], held[self._set] = self._nu, True
        return Held(multipliers, held, status)

    def _begin(self, active: NDArray[np.bool_]) -> None:
        for row in np.flatnonzero(active)[: self._capacity]:
            self._add(int(row), self._respond(int(row)))
        while self._set:
            self._nu = self._solved(self._free[self._set])
            if (self._nu >= 0).all():
                break
            self._release(int(np.argmin(self._nu)))

    def _values(self) -> Array:
        """Return the rows' values (n_rows,) at the present multipliers."""
        values = self._free.copy()
        for column, nu in zip(self._columns, self._nu, strict=True):
            values -= column * nu
        return values

    def _most_exceeded(self, values: Array) -> int | None:
        free = self._std > 0
        free[self._set] = False
        excess = np.full(len(values), -np.inf)
        excess[free] = values[free] / self._std[free]
        worst = int(np.argmax(excess)) if len(excess) else 0
        return worst if len(excess) and excess[worst] > EXCESS else None

    def _raise(self, p: int, left: float) -> Status:
        """Raise the multiplier of row p until the row is met."""
        own = self._respond(p)
        taken = 0.0
        while True:
            step = self._solved(own[self._set])
            curvature = own[p] - own[self._set] @ step
            ratios = np.full(len(step), np.inf)
            np.divide(self._nu, step, out=ratios, where=step > 0)
            blocking = int(np.argmin(ratios)) if len(ratios) else -1
            most = ratios[blocking] if len(ratios) else np.inf
            is_free = curvature > DEPENDENT * own[p]
            t = min(most, left / curvature if is_free else np.inf)
            if not np.isfinite(t):
                return Status.INFEASIBLE
            self._nu = self._nu - t * step
            taken += t
            left -= t * curvature if is_free else 0.0
            if t < most:
                break
            self._release(blocking)
        if not self._add(p, own):
            return Status.SOLVER_FAILED
        self._nu = np.maximum(self._solved(self._free[self._set]), 0)
        return Status.SOLVED

    def _add(self, row: int, column: Array) -> bool:
        """Take a row into the set, unless it depends on those that are in it."""
        in_set, own = column[self._set], float(column[row])
        below = self._lower_solved(in_set)
        left = own - below @ below
        if not left > DEPENDENT * own:
            return False
        n = len(self._set)
        factor = np.zeros((n + 1, n + 1))
        factor[:n, :n], factor[n, :n], factor[n, n] = self._factor, below, np.sqrt(left)
        self._factor = factor
        self._set.append(row)
        self._columns.append(column)
        self._nu = np.append(self._nu, 0.0)
        return True

    def _release(self, a: int) -> None:
        del self._set[a], self._columns[a]
        self._nu = np.delete(self._nu, a)
        M = np.array([column[self._set] for column in self._columns])
        self._factor = np.linalg.cholesky(M) if len(M) else np.zeros((0, 0))

    def _solved(self, right: Array) -> Array:
        """Return M_AA⁻¹ times a vector."""
        if not self._set:
            return np.zeros(0)
        solved: Array = cho_solve((self._factor, True), right, check_finite=False)
        return solved

    def _lower_solved(self, right: Array) -> Array:
        if not self._set:
            return np.zeros(0)
        solved: Array = solve_triangular(self._factor, right, lower=True, check_finite=False)
        return solved
