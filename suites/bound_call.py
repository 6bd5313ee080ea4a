"""A CasADi function between fixed arrays: no conversion, no copy, at a call."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np


class BoundCall:
    """A CasADi function whose arguments and results stay where they are.

    Parameters
    ----------
    arguments, results : flat arrays, one per argument and result: its nonzeros, column by column
    """

    def __init__(self, function: ca.Function) -> None:
        self.arguments = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        self.results = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        self._buffer, self.evaluate = function.buffer()
        buffer: Any = self._buffer  # its type declares arguments that the call does not take
        for i, argument in enumerate(self.arguments):
            buffer.set_arg(i, argument.data)
        for i, result in enumerate(self.results):
            buffer.set_res(i, result.data)
