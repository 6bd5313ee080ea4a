"""The unscented Kalman filter as textbooks have it, in NumPy: weights, states that add, all rows.

Särkkä (2013), Bayesian Filtering and Smoothing, Algorithm 5.14 (augmented), with points drawn anew
for the update; weights as of Wan, van der Merwe (2000).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Moments = tuple[Array, Array]


def points(moments: Moments, told: tuple[float, float, float]) -> tuple[Array, Array, Array]:
    """Return 2 n + 1 points (n, 2 n + 1) and the weights of mean and covariance."""
    (mean, P), (alpha, beta, kappa) = moments, told
    n = len(mean)
    scale = alpha**2 * (n + kappa) - n
    L = np.sqrt(n + scale) * np.linalg.cholesky(P)
    W = np.full(2 * n + 1, 0.5 / (n + scale))
    W[0] = scale / (n + scale)
    W_c = W.copy()
    W_c[0] += 1 - alpha**2 + beta
    return mean[:, None] + np.hstack([np.zeros((n, 1)), L, -L]), W, W_c


def predict(
    moments: Moments,
    f: Callable[[Array, Array], Array],
    n_w: int,
    told: tuple[float, float, float],
) -> Moments:
    """Take N(x, P) through f(x, w), w ~ N(0, I)."""
    n = len(moments[0])
    both = np.zeros((n + n_w, n + n_w))
    both[:n, :n], both[n:, n:] = moments[1], np.eye(n_w)
    chi, W, W_c = points((np.concatenate([moments[0], np.zeros(n_w)]), both), told)
    reached = np.array([f(c[:n], c[n:]) for c in chi.T]).T
    mean = reached @ W
    off = reached - mean[:, None]
    return mean, off @ np.diag(W_c) @ off.T


def update(
    moments: Moments,
    y: Array,
    h: Callable[[Array], Array],
    R: Array,
    told: tuple[float, float, float],
) -> Moments:
    """Condition N(x, P) on y = h(x) + e, e ~ N(0, R)."""
    chi, W, W_c = points(moments, told)
    read = np.array([h(c) for c in chi.T]).T
    mean = read @ W
    off = read - mean[:, None]
    S = off @ np.diag(W_c) @ off.T + R
    C = (chi - moments[0][:, None]) @ np.diag(W_c) @ off.T
    K = C @ np.linalg.inv(S)
    return moments[0] + K @ (y - mean), moments[1] - K @ S @ K.T
