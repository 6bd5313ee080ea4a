"""What the parts of a pass over a window leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimation.kalman_stage import Prediction, Update
from mhe.interpreted.active_set import Held
from models.arrays import Array


@dataclass(frozen=True, eq=False)
class Forward:
    """What the forward pass leaves: one update per stage, one prediction between two."""

    updates: list[Update]
    predictions: list[Prediction]
    noises: Array


@dataclass(frozen=True, eq=False)
class Smoothed:
    """What the pass back leaves.

    Parameters
    ----------
    d : (n, n_x) deviations of the linearised window's optimum from the trajectory
    mu, w : (n_x,), (n - 1, n_w) multiplier of its prior, x_0 = x̄ ⊞ P̄ μ, and its noises
    length : squared length of the step in whitened units, without the prior's part; NaN
        where the pass is not finite
    expected : (n, n_r) the optimum's residuals, in standard deviations of their noise, as the
        linearised stages have them
    oldest : where the pass ended; stages before this one keep what the window has of them, and
        have new deviations only where a lag speaks of them
    """

    d: Array
    mu: Array
    w: Array
    length: float
    expected: Array
    oldest: int


@dataclass(frozen=True, eq=False)
class Pass(Smoothed):
    """Result of a pass over a window.

    Parameters
    ----------
    newest : update of the newest stage
    covariances : (n, n_x, n_x) P⁺ of the stages
    held : rows that hold it, and their multipliers
    row_std : (n, n_c) standard deviations of the rows
    cost : of the linearised window's optimum, ½ the sum of squares
    forward : the factors that it went back on
    """

    newest: Update
    covariances: Array
    held: Held
    row_std: Array
    cost: float
    forward: Forward

    @property
    def moved(self) -> Array:
        """(n,) the largest squared deviation of each stage, in variances."""
        variances = np.diagonal(self.covariances, axis1=1, axis2=2)
        squares = self.d**2
        ratios = np.zeros(squares.shape)
        np.divide(squares, variances, out=ratios, where=squares > 0)
        largest: Array = ratios.max(axis=1)
        return largest
