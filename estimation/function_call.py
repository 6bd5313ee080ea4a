"""Calling a CasADi function on NumPy arrays without conversions.

CasADi's plain call turns every array into a sparse matrix and back, which
takes longer than the function itself. A `FunctionCall` owns fixed buffers.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from models.arrays import Array


class FunctionCall:
    """A CasADi function on dense arrays, bound to its own workspace.

    Not to be shared between threads: it owns the buffers. Results are copies.
    """

    def __init__(self, function: ca.Function) -> None:
        self.function = function
        self._inputs = [_Buffer(function.sparsity_in(i)) for i in range(function.n_in())]
        self._outputs = [_Buffer(function.sparsity_out(i)) for i in range(function.n_out())]
        self._buffer, self._evaluate = function.buffer()
        buffer: Any = self._buffer  # its type declares arguments that the call does not take
        for i, argument in enumerate(self._inputs):
            buffer.set_arg(i, argument.nonzeros.data)
        for i, result in enumerate(self._outputs):
            buffer.set_res(i, result.nonzeros.data)

    def __call__(self, *arguments: ArrayLike) -> list[Array]:
        """Evaluate; columns come back as (n,), anything else as (n, m)."""
        for buffer, argument in zip(self._inputs, arguments, strict=True):
            value = np.asarray(argument, dtype=float)
            if value.ndim < 2:
                value = value.reshape(-1, 1)
            if value.shape != buffer.shape:
                raise ValueError(
                    f"{self.function.name()}: argument of shape {value.shape}, "
                    f"expected {buffer.shape}"
                )
            buffer.take(value)
        self._evaluate()
        return [result.dense() for result in self._outputs]


class _Buffer:
    """The nonzeros of one argument or result, and where in the matrix they belong."""

    def __init__(self, sparsity: ca.Sparsity) -> None:
        self.shape = tuple(sparsity.shape)
        self.rows, self.columns = (np.array(index, dtype=int) for index in sparsity.get_triplet())
        self.nonzeros = np.zeros(sparsity.nnz())
        is_full = sparsity.is_dense()  # then nonzeros are the matrix, column by column
        self._whole = self.nonzeros.reshape(self.shape, order="F") if is_full else None

    def take(self, matrix: Array) -> None:
        if self._whole is not None:
            self._whole[...] = matrix
        else:
            self.nonzeros[...] = matrix[self.rows, self.columns]

    def dense(self) -> Array:
        if self._whole is not None:
            matrix = self._whole.copy()
        else:
            matrix = np.zeros(self.shape)
            matrix[self.rows, self.columns] = self.nonzeros
        return matrix[:, 0] if self.shape[1] == 1 else matrix
