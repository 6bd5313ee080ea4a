"""The overlapping Allan variance, and how far an estimate of it strays.

For neighbouring clusters of m samples with means ȳ_k, ȳ_{k+m}

    σ²(τ) = ½ E (ȳ_{k+m} - ȳ_k)²,   τ = m Δt

White noise of density N and a random walk of density K give N²/τ and K² τ/3.

References
----------
IEEE Std 952-1997, annex C. Riley (2008), NIST Special Publication 1065, 5.2.4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def allan_variance(values: Array, m: int) -> float:
    """Return the overlapping estimate over clusters of m samples, values (n,)."""
    total = np.concatenate([[0.0], np.cumsum(values - values.mean())])
    means = (total[m:] - total[:-m]) / m
    return float(np.mean((means[m:] - means[:-m]) ** 2) / 2)


def relative_error(kernel: Array, m: int, n: int) -> float:
    """Return the standard error of an estimate from n samples over its mean, exactly.

    The cluster differences d are Gaussian with covariances r_j, so the mean of M
    squares has the variance ``2/M² Σ_j (M - |j|) r_j²``.

    Parameters
    ----------
    kernel : d as a filter on independent samples: see `white_kernel`, `walk_kernel`
    """
    terms = n - 2 * m + 1
    r = np.correlate(kernel, kernel, mode="full")
    lag = np.abs(np.arange(len(r)) - len(kernel) + 1)
    variance = 2 / terms**2 * np.sum(np.maximum(terms - lag, 0) * r**2)
    return float(np.sqrt(variance) / r[len(kernel) - 1])


def white_kernel(m: int) -> Array:
    """Difference of neighbouring cluster means of independent samples."""
    return np.concatenate([np.full(m, -1 / m), np.full(m, 1 / m)])


def walk_kernel(m: int) -> Array:
    """The same for a walk, on its independent steps."""
    return np.convolve(np.ones(m), np.full(m, 1 / m))
