"""One cost for all contenders: ½ the sum of squares of a window at a first state and noises.

    J = ½‖L̄⁻¹ (x_0 - x̄)‖² + ½ Σ_k ‖present_k · residual(y_k, x_k) / σ‖² + ½ Σ_k ‖w_k‖²

with x_{k+1} = f(x_k, w_k, Δt_k) rolled out: a contender whose states break the dynamics
pays for it here.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.linalg import solve_triangular

from estimation.symbolic_stage import stacked_residual
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.speed.windows import SpeedWindow


class WindowCost:
    """The cost of windows with N intervals of one model."""

    def __init__(self, model: StateSpaceModel, horizon: int) -> None:
        self.model = model
        x, y = ca.SX.sym("x", model.n_x), ca.SX.sym("y", model.n_y)
        residual = stacked_residual(model, y, x) / model.noise_std
        self._residual = ca.Function("residual", [x, y], [residual]).map(horizon + 1)
        self._roll = model.f.mapaccum(horizon)

    def states(self, window: SpeedWindow, start: Array, noises: Array) -> Array:
        """Return the states (N + 1, n_x) from a first state (n_x,) and noises (N, n_w)."""
        reached = self._roll(start, noises.T, window.dt[None, :]).full()
        return np.vstack([start, reached.T])

    def __call__(self, window: SpeedWindow, start: Array, noises: Array) -> float:
        """Return J of a first state (n_x,) and noises (N, n_w)."""
        away = self.model.difference(start, window.prior.mean).full().ravel()
        whitened = solve_triangular(window.prior_factor, away, lower=True)
        states = self.states(window, start, noises)
        residuals = self._residual(states.T, window.y.T).full().T * window.present
        return 0.5 * float(np.sum(whitened**2) + np.sum(residuals**2) + np.sum(noises**2))
