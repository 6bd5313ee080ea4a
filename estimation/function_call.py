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
    """A CasADi function with dense results, bound to its own workspace.

    Not to be shared between threads: it owns the buffers. Results are copies.
    """

    def __init__(self, function: ca.Function) -> None:
        self.function = function
        for i in range(function.n_in()):
            if not function.sparsity_in(i).is_dense():
                raise ValueError(f"{function.name()}: argument {i} is sparse, expected dense")
        for i in range(function.n_out()):
            if not function.sparsity_out(i).is_dense():
                raise ValueError(f"{function.name()}: result {i} is sparse, expected dense")
        flat_inputs = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
        flat_outputs = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        self._inputs = [
            flat.reshape(function.size_in(i), order="F") for i, flat in enumerate(flat_inputs)
        ]
        self._outputs = [
            flat.reshape(function.size_out(i), order="F") for i, flat in enumerate(flat_outputs)
        ]
        self._buffer, self._evaluate = function.buffer()
        buffer: Any = self._buffer  # its type declares arguments that the call does not take
        for i, flat in enumerate(flat_inputs):
            buffer.set_arg(i, flat.data)
        for i, flat in enumerate(flat_outputs):
            buffer.set_res(i, flat.data)

    def __call__(self, *arguments: ArrayLike) -> list[Array]:
        """Evaluate; vectors come back as (n,), matrices as (n, m)."""
        for array, argument in zip(self._inputs, arguments, strict=True):
            value = np.asarray(argument, dtype=float)
            if value.ndim < 2:
                value = value.reshape(-1, 1)
            if value.shape != array.shape:
                raise ValueError(
                    f"{self.function.name()}: argument of shape {value.shape}, "
                    f"expected {array.shape}"
                )
            array[...] = value
        self._evaluate()
        return [
            result[:, 0].copy() if result.shape[1] == 1 else result.copy(order="C")
            for result in self._outputs
        ]
