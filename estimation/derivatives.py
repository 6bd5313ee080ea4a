"""A model's derivatives at given points, by CasADi's virtual machine: nothing is compiled."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import casadi as ca
import numpy as np

from estimation.function_call import FunctionCall
from estimation.kalman_stage import rows_present, without_gaps
from estimation.symbolic_stage import (
    residual_derivative,
    stacked_residual,
    step_derivatives,
    step_symbols,
)
from models.arrays import Array
from models.state_space import StateSpaceModel


class Derivatives:
    """F, G and H of a model, along its tangent spaces; one instance is for one thread."""

    def __init__(self, model: StateSpaceModel) -> None:
        self.model = model
        self._step, self._readings = (FunctionCall(f) for f in _functions(model))
        self._no_noise = np.zeros(model.n_w)

    def of_step(self, x: Array, dt: float, *, inputs: Sequence[Array] = ()) -> tuple[Array, Array]:
        """Return F (n_x, n_x) and G (n_x, n_w) of a step of `dt` seconds at x, without noise.

        Parameters
        ----------
        inputs : (n_u,) at both ends of the step, where the model has some
        """
        n_x, n_w = self.model.n_x, self.model.n_w
        F, G = self._step(x, self._no_noise, dt, *inputs)
        return F.reshape(n_x, n_x), G.reshape(n_x, n_w)

    def of_readings(self, x: Array, y: Array) -> Array:
        """Return H (n_r, n_x) of stacked readings at x; rows without a reading are zero."""
        H = self._readings(x, without_gaps(y))[0].reshape(self.model.n_r, self.model.n_x)
        H[~rows_present(self.model, y)] = 0
        return H


@lru_cache(maxsize=16)
def _functions(model: StateSpaceModel) -> tuple[ca.Function, ca.Function]:
    """Return (x, w, Δt, inputs of both ends) → (F, G), and (x, y) → H."""
    x, w, dt = ca.SX.sym("x", model.n_x), ca.SX.sym("w", model.n_w), ca.SX.sym("dt")
    y, inputs = ca.SX.sym("y", model.n_row), step_symbols(model).values()
    _, F, G = step_derivatives(model, x, w, dt, *inputs)
    H = residual_derivative(model, stacked_residual(model, y, x), x)
    return (
        ca.Function("step_derivatives", [x, w, dt, *inputs], [F, G]),
        ca.Function("reading_derivatives", [x, y], [H]),
    )
