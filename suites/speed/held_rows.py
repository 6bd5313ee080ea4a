"""Rows of bounds and inequalities along a window, in standard deviations.

    g(x_k) ≤ 0,   one standard deviation of row j: ‖D C_j‖,   C = ∂gᵀ/∂δ

with D the scale of a window's states; of a bound it is that of its state.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimation.recording import Measurement
from mhe import constraint_rows
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.speed.windows import SpeedWindow

ACTIVE_STD = 1e-6
"""A row that is met by less than that counts as active; the reference is as exact."""


class HeldRows:
    """What the bounds and inequalities of one model do to a window.

    Parameters
    ----------
    n_c : how many rows a stage has
    """

    def __init__(self, model: StateSpaceModel) -> None:
        self.n_c, self._model = constraint_rows.count(model), model
        self._constrain = constraint_rows.constrain_function(model)

    def excess(self, measurements: Sequence[Measurement], states: Array, scale: Array) -> Array:
        """Return g (N + 1, n_c) in standard deviations, -∞ for a row that is not demanded.

        Parameters
        ----------
        measurements, states : N + 1 stages, (N + 1, n_x)
        scale : (n_x,) standard deviations of the states
        """
        excess = np.full((len(states), self.n_c), -np.inf)
        for k, (x, measurement) in enumerate(zip(states, measurements, strict=True)):
            g, C = (part.full() for part in self._constrain(x))
            std = np.linalg.norm(scale[:, None] * C, axis=0)
            demanded = constraint_rows.demanded(self._model, measurement.y)
            excess[k, demanded] = (g.ravel() / std)[demanded]
        return excess

    def active(
        self, measurements: Sequence[Measurement], states: Array, scale: Array
    ) -> NDArray[np.bool_]:
        """Return which rows (N + 1, n_c) are active; parameters as of `excess`."""
        rows: NDArray[np.bool_] = self.excess(measurements, states, scale) > -ACTIVE_STD
        return rows

    def violation(self, window: SpeedWindow, states: Array) -> float:
        """Return the largest excess of any row of a window, zero where all are met."""
        excess = self.excess(window.measurements, states, window.scale)
        return float(excess.max(initial=0.0))
