"""A window linearised at a trajectory: what a QP of it is made of, from the Kalman stage.

With deviations δ from a trajectory (x̃, w̃), unit noises ω = D⁻¹ w and residuals in standard
deviations, and everything else as in `estimation.kalman_stage`:

    δ_{k+1} = F δ_k + G D ω_k + b,   b = f(x̃_k, w̃_k) ⊟ x̃_{k+1} - G w̃_k
    r_k = v - H δ_k,                 g(x̃_k) + Cᵀ δ_k ≤ 0
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from estimation.function_call import FunctionCall
from estimation.kalman_stage import KalmanStage
from estimation.symbolic_stage import difference_function
from mhe.constraint_rows import constrain_function
from mhe.stage_functions import carry_function
from mhe.window_memory import Scales
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


class WindowStages(Protocol):
    """What is linearised; `mhe.window_memory.View` is one.

    Attributes
    ----------
    times, y : (n,), (n, n_row) instants, and readings with zero where there is none
    x, w : (n, n_x), (n - 1, n_w) the trajectory (x̃, w̃)
    prior : of the first stage
    """

    @property
    def times(self) -> Array: ...  # noqa: D102
    @property
    def y(self) -> Array: ...  # noqa: D102
    @property
    def x(self) -> Array: ...  # noqa: D102
    @property
    def w(self) -> Array: ...  # noqa: D102
    @property
    def prior(self) -> GaussianState: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Linearised:
    """The matrices of all n stages; see the module's equations.

    Parameters
    ----------
    F, GD, b : (n - 1, n_x, n_x), (n - 1, n_x, n_w), (n - 1, n_x)
    H, v : (n, n_r, n_x), (n, n_r), over the readings' standard deviations
    g, C : (n, n_c), (n, n_x, n_c)
    newest : covariance (n_x, n_x) of the newest state, without constraints
    """

    F: Array
    GD: Array
    b: Array
    H: Array
    v: Array
    g: Array
    C: Array
    newest: Array


class Lineariser:
    """Linearises windows of one model; it owns work buffers."""

    def __init__(self, model: StateSpaceModel) -> None:
        self.model, self.stage = model, KalmanStage(model)
        self._difference = FunctionCall(difference_function(model))
        self._constrain = FunctionCall(constrain_function(model))
        carry = carry_function(model)
        self._carry = None if carry is None else FunctionCall(carry)

    def difference(self, x: Array, origin: Array) -> Array:
        """Return x ⊟ origin (n_x,)."""
        return self._difference(x, origin)[0]

    def carried(self, prior: GaussianState, d: Array, x: Array) -> tuple[GaussianState, Array]:
        """Return prior and deviation from it in the tangent space at x = x̄ ⊞ d.

        See `mhe.stage_functions.carry_function`; where states add they are as they were.
        """
        if self._carry is None:
            return prior, d
        [J] = self._carry(prior.mean, d, x)
        J = J.reshape(len(d), len(d))
        return GaussianState(prior.mean, J @ prior.covariance @ J.T), J @ d

    @np.errstate(over="ignore", invalid="ignore")  # absurd readings: the status says it
    def __call__(
        self, window: WindowStages, scales: Scales, *, prior: GaussianState | None = None
    ) -> Linearised:
        """Run the Kalman stage over the window with all deviations zero.

        Parameters
        ----------
        prior : of `carried`, for the covariances; the window's own by default
        """
        model, n = self.model, len(window.times)
        n_x, n_c = model.n_x, int(self._constrain.function.numel_out("g"))
        F, GD = np.zeros((n - 1, n_x, n_x)), np.zeros((n - 1, n_x, model.n_w))
        b, g, C = np.zeros((n - 1, n_x)), np.zeros((n, n_c)), np.zeros((n, n_x, n_c))
        H, v = np.zeros((n, model.n_r, n_x)), np.zeros((n, model.n_r))
        at_zero, gaussian = np.zeros(n_x), window.prior if prior is None else prior
        for k in range(n):
            if k:
                dt = float(window.times[k] - window.times[k - 1])
                at = window.x[k - 1], window.w[k - 1], scales.noises[k - 1], at_zero
                inputs = model.step_inputs(window.y[k - 1], window.y[k])
                ahead = self.stage.predict(gaussian, dt, *at, inputs=inputs)
                F[k - 1], GD[k - 1] = ahead.F, ahead.G * scales.noises[k - 1]
                defect = self.difference(ahead.reached, window.x[k])
                b[k - 1] = defect - ahead.G @ window.w[k - 1]
                gaussian = ahead.state
            update = self.stage.update(gaussian, window.y[k], scales.rows[k], window.x[k], at_zero)
            H[k] = update.H / model.noise_std[:, None]
            v[k] = update.innovation / model.noise_std
            gaussian = update.state
            g[k], slopes = self._constrain(window.x[k])
            C[k] = slopes.reshape(n_x, n_c)
        return Linearised(F, GD, b, H, v, g, C, gaussian.covariance)
