"""A Gaussian over the state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array


@dataclass(frozen=True, eq=False)
class GaussianState:
    """A Gaussian over the state: mean (n_x,) and covariance (n_x, n_x), model units."""

    mean: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviations (n_x,)."""
        return np.sqrt(np.diag(self.covariance))
