"""A covariance as estimators keep it between steps: padded, or a root where that is needed.

Rows are as long as C's vectors want them, with zeros behind. Where P has lost too many digits the
array holds a lower triangular root S, P = S Sᵀ, instead, whose diagonal is not positive: the sign
of the first number tells (estimation/covariance_form.c).
"""

from __future__ import annotations

import numpy as np

from models.arrays import Array
from models.gaussian import GaussianState

QUAD = 4
"""Numbers that C adds at once; the rows of a stored covariance are a multiple of it."""


def stride(n_x: int) -> int:
    """Return the length of a row."""
    return -(-n_x // QUAD) * QUAD


def store(gaussian: GaussianState, kept: Array) -> None:
    """Write a covariance, or the root that stands for it, into an array (stride, stride)."""
    kept[...] = padded(gaussian.covariance if gaussian.root is None else gaussian.root)


def padded(matrix: Array) -> Array:
    """Return a matrix (n, n) with zeros behind, (stride, stride)."""
    n, row = len(matrix), stride(len(matrix))
    kept = np.zeros((row, row))
    kept[:n, :n] = matrix
    return kept


def stored(gaussian: GaussianState) -> Array:
    """Return what `store` writes, (stride, stride)."""
    row = stride(len(gaussian.mean))
    kept = np.empty((row, row))
    store(gaussian, kept)
    return kept


def restored(mean: Array, kept: Array) -> GaussianState:
    """Return the Gaussian of a mean (n_x,) and of what `store` wrote."""
    n_x = len(mean)
    held = kept[:n_x, :n_x]
    if np.signbit(held[0, 0]):
        return GaussianState(mean, held @ held.T, held)
    return GaussianState(mean, held)
