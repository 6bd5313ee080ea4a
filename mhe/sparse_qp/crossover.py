"""From about the optimum of a QP to the optimum: the rows that hold it, as equations.

    min ½ zᵀ P z   s.t.   l ≤ A z ≤ u,   rows with l = u are equations, others have u only

With a set S of rows held, the optimality conditions are one linear system,

    [P   Aₛᵀ] [z]   [0 ]
    [Aₛ  0  ] [y] = [uₛ]

The right set is found as non-negative least squares finds it, on the dual problem: begin with a
guess, without rows that pull (y < 0). Then hold the row that is exceeded most. If some
others pull now, go towards the new multipliers only until the first of them is zero, let that
one go, and solve again. The dual cost rises at every turn, so no set comes twice.

References
----------
Lawson, Hanson (1974), Solving least squares problems, chapter 23.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from models.arrays import Array

MOST_TURNS = 500
REGULARISATION, REFINEMENTS = 1e-10, 6
CONTRADICTION = 1e-11
"""Residual, relative to the largest unknown, above which held rows cannot all be met."""


def crossed_over(
    P: sp.csc_matrix,
    A: sp.csc_matrix,
    lower: Array,
    upper: Array,
    guess: NDArray[np.bool_],
    tolerance: float,
) -> tuple[Array, Array] | None:
    """Return z and y of the optimum; None where no set of rows is found that holds it.

    Parameters
    ----------
    guess : rows that hold it; equations do in any case
    tolerance : of what a row may be exceeded by, relative to the largest variable
    """
    qp = _Qp(sp.csc_array(P), sp.csr_array(A), upper, lower == upper)
    held = (guess & np.isfinite(upper)) | qp.equal
    point = qp.held(held)
    while point.is_met and qp.pulls(point, held).any():
        held = held & ~qp.pulls(point, held)
        point = qp.held(held)
    if not point.is_met:  # rows of the guess contradict each other
        held = qp.equal
        point = qp.held(held)
        if not point.is_met:
            return None
    for _ in range(MOST_TURNS):
        excess = np.where(held, -np.inf, qp.A @ point.z - upper)
        worst = int(np.argmax(excess))
        if not excess[worst] > tolerance * max(1.0, np.abs(point.z).max(initial=0.0)):
            return point.z, point.y
        held = held.copy()
        held[worst] = True
        y, point = point.y, qp.held(held)
        while (pulls := qp.pulls(point, held)).any():
            part = y[pulls] / (y[pulls] - point.y[pulls])
            y = y + part.min() * (point.y - y)
            held[np.flatnonzero(pulls)[part == part.min()]] = False
            y = np.where(held, y, 0)
            point = qp.held(held)
        if not point.is_met:
            return None
    return None


@dataclass(frozen=True, eq=False)
class _KktPoint:
    """z and y with some rows held, and whether these could be met all at once."""

    z: Array
    y: Array
    is_met: bool


@dataclass(frozen=True, eq=False)
class _Qp:
    """A QP; `equal` marks its equations."""

    P: sp.csc_array
    A: sp.csr_array
    upper: Array
    equal: NDArray[np.bool_]

    def pulls(self, point: _KktPoint, rows: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which of the rows that are held have a negative multiplier."""
        return rows & ~self.equal & (point.y < 0)

    def held(self, rows: NDArray[np.bool_]) -> _KktPoint:
        """Solve the optimality conditions with some rows held.

        Rows that depend on each other make the system singular: a little on its diagonal
        mends that, and refinement takes it back where the rows can be met.
        """
        A, n = self.A[rows], self.P.shape[0]
        blocks: list[list[sp.sparray | None]] = [[self.P, A.T], [A, None]]
        system = sp.csc_array(sp.block_array(blocks, format="csc"))
        little = np.concatenate([np.full(n, REGULARISATION), np.full(A.shape[0], -REGULARISATION)])
        factors = splu(sp.csc_matrix(system + sp.diags_array(little)))
        right = np.concatenate([np.zeros(n), self.upper[rows]])
        found = factors.solve(right)
        for _ in range(REFINEMENTS):
            found = found + factors.solve(right - system @ found)
        off = np.abs(right - system @ found).max(initial=0.0)
        y = np.zeros(len(rows))
        y[rows] = found[n:]
        is_met = bool(off <= CONTRADICTION * max(1.0, np.abs(found).max(initial=0.0)))
        return _KktPoint(found[:n], y, is_met)
