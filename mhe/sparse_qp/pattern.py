"""Where everything stands in the QP of a linearised window, see `mhe.sparse_qp.osqp_window`.

Found once per model and length: later windows hand over values only, in the order of A's
column-wise storage.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from estimation.kalman_stage import KalmanStage
from estimation.layout import Layout
from mhe.constraint_rows import count, slope_pattern
from models.arrays import Array

Indices = NDArray[np.int_]


class QpPattern:
    """Variables, rows and the nonzeros of P and A, of n stages.

    Parameters
    ----------
    stage : of the model
    n : number of stages

    Attributes
    ----------
    variables : u, δ̂, ω and r as blocks of the unknown
    rows : the four kinds of rows
    """

    def __init__(self, stage: KalmanStage, n: int) -> None:
        model = stage.model
        n_x, n_w, n_r = model.n_x, model.n_w, model.n_r
        self.variables = Layout(
            "Variables",
            {"u": (n_x,), "delta": (n, n_x), "noise": (n - 1, n_w), "residual": (n, n_r)},
        )
        self.rows = Layout(
            "Rows",
            {
                "prior": (n_x,),
                "steps": (n - 1, n_x),
                "readings": (n, n_r),
                "constraints": (n, count(model)),
            },
        )
        predict, update = stage.functions
        self._L = np.tril_indices(n_x)
        self._F = _nonzeros(predict.sparsity_out("F"))
        self._G = _nonzeros(predict.sparsity_out("G"))
        self._H = _nonzeros(update.sparsity_out("H"))
        self._C = _nonzeros(slope_pattern(model))
        column, row = _numbered(self.variables), _numbered(self.rows)
        ones = [
            (row["prior"], column["delta"][0]),
            (row["steps"], column["delta"][1:]),
            (row["readings"], column["residual"]),
        ]
        blocks = [
            *ones,
            (row["prior"][self._L[0]], column["u"][self._L[1]]),
            (row["steps"][:, self._F[0]], column["delta"][:-1, self._F[1]]),
            (row["steps"][:, self._G[0]], column["noise"][:, self._G[1]]),
            (row["readings"][:, self._H[0]], column["delta"][:, self._H[1]]),
            (row["constraints"][:, self._C[1]], column["delta"][:, self._C[0]]),
        ]
        self._ones = np.ones(sum(rows.size for rows, _ in ones))
        i = np.concatenate([rows.ravel() for rows, _ in blocks])
        j = np.concatenate([columns.ravel() for _, columns in blocks])
        labels = sp.csc_matrix(
            (np.arange(len(i), dtype=float), (i, j)), (self.rows.size, self.variables.size)
        )
        labels.sort_indices()
        self._order, self._labels = labels.data.astype(int), labels

    @property
    def hessian(self) -> sp.csc_matrix:
        """P: one for everything that is white, zero for the deviations."""
        diagonal = np.ones(self.variables.size)
        diagonal[self.variables.slices["delta"]] = 0
        return sp.csc_matrix(sp.diags_array(diagonal))

    def matrix(self, values: Array) -> sp.csc_matrix:
        """A with some `values`."""
        A = self._labels.copy()
        A.data = values.copy()
        return A

    def values(self, L: Array, F: Array, G: Array, H: Array, C: Array) -> Array:
        """Return the nonzeros of A, column by column.

        Parameters
        ----------
        L, F, G, H, C : scaled; (n_x, n_x), and as of `mhe.sparse_qp.linearised_window.Linearised`
        """
        parts = [
            self._ones,
            -L[self._L],
            -F[:, *self._F].ravel(),
            -G[:, *self._G].ravel(),
            H[:, *self._H].ravel(),
            C[:, *self._C].ravel(),
        ]
        found: Array = np.concatenate(parts)[self._order]
        return found


def _nonzeros(pattern: ca.Sparsity) -> tuple[Indices, Indices]:
    """Return rows and columns."""
    rows, columns = pattern.get_triplet()
    return np.array(rows, dtype=int), np.array(columns, dtype=int)


def _numbered(layout: Layout) -> dict[str, Indices]:
    """Return block → positions of its entries in the flat array, in its shape."""
    every = np.arange(layout.size)
    return {block: every[layout.slices[block]].reshape(s) for block, s in layout.shapes.items()}
