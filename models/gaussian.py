"""A Gaussian over the state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array


@dataclass(frozen=True, eq=False)
class GaussianState:
    """A Gaussian over the state, in model units.

    Parameters
    ----------
    mean : (n_x,)
    covariance : (n_x, n_x)
    root : (n_x, n_x) S, S Sᵀ the covariance, where that alone would have lost its digits: readings
        so much better than what was known that the difference of two covariances is rounding
    """

    mean: Array
    covariance: Array
    root: Array | None = None

    @property
    def std(self) -> Array:
        """Standard deviations (n_x,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def is_finite(self) -> bool:
        """Whether all of it is numbers."""
        return bool(np.isfinite(self.mean).all() and np.isfinite(self.covariance).all())
