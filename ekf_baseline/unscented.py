"""The unscented transform on a manifold: what a Gaussian becomes behind a function.

Of x ~ N(x̄, P) with n dimensions, noise of its own among them, and P = L Lᵀ:

    χ₀ = x̄,   χᵢ = x̄ ⊞ ± c Lᵢ,   c² = α² (n + κ),   W = 1 / (2 c²)
    dᵢ = g(χᵢ) ⊟ g(χ₀),   δ = W Σ dᵢ
    ȳ = g(χ₀) ⊞ δ,   P_y = W Σ dᵢ dᵢᵀ + (β - α²) δ δᵀ,   C = W Σ (± c Lᵢ) dᵢᵀ

This is the scaled transform: with its weights W₀ = 1 - n / c² of the mean and W₀ + 1 - α² + β of
the covariance the sums are the same numbers. Written about g(χ₀) no weight is negative and nothing
large cancels, so that P_y is positive semidefinite for every β ≥ α², and the mean of points on a
manifold needs no iteration.

References
----------
Julier (2002), The scaled unscented transformation, American Control Conference.
Wan, van der Merwe (2000), The unscented Kalman filter for nonlinear estimation, IEEE AS-SPCC.
Brossard, Barrau, Bonnabel (2020), A code for unscented Kalman filtering on manifolds, ICRA.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array


@dataclass(frozen=True)
class Spread:
    """Where the points of a transform of n dimensions lie, and what they weigh.

    Parameters
    ----------
    radius : c, by how many standard deviations a point is off the mean
    weight : W of each point but the central one
    bend : β - α², weight of what the mean moves
    """

    radius: float
    weight: float
    bend: float

    @classmethod
    def of(cls, n: int, alpha: float, beta: float, kappa: float) -> Spread:
        """Return it for n dimensions; see the module's equations."""
        square = alpha**2 * (n + kappa)
        return cls(np.sqrt(square), 0.5 / square, beta - alpha**2)

    def points(self, roots: Array) -> Array:
        """Return ± c Lᵢ (n, 2 m) of columns (n, m)."""
        return self.radius * np.hstack([roots, -roots])

    def mean(self, apart: Array) -> Array:
        """Return δ (k,) of dᵢ (k, 2 n)."""
        return self.weight * apart.sum(axis=1)

    def factors(self, apart: Array) -> Array:
        """Return A (k, 2 n + 1) with A Aᵀ = P_y, of dᵢ (k, 2 n)."""
        return np.column_stack(
            [np.sqrt(self.weight) * apart, np.sqrt(self.bend) * self.mean(apart)]
        )


def root(P: Array) -> Array:
    """Return L (n, n) with L Lᵀ = P; of what is singular to rounding, its symmetric root."""
    try:
        return np.asarray(np.linalg.cholesky(P))
    except np.linalg.LinAlgError:
        size = np.sqrt(np.maximum(np.diag(P), np.finfo(float).tiny))
        values, vectors = np.linalg.eigh(P / np.outer(size, size))
        return np.asarray(size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))
