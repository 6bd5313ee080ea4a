"""The Rauch-Tung-Striebel smoother as textbooks have it, in NumPy.

Särkkä (2013), Bayesian Filtering and Smoothing, Theorem 8.2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tests.references.kalman import Posterior, predict
from tests.references.kalman import run as run

Array = NDArray[np.float64]


def smoothed(
    filtered: Sequence[Posterior],
    times: Sequence[float],
    F: Callable[[float], Array],
    Q: Callable[[float], Array],
    newest: int,
    lag: int,
) -> tuple[Array, Array]:
    """Return mean and covariance `lag` readings before number `newest`, given all up to it."""
    x, P = filtered[newest].mean, filtered[newest].covariance
    for k in reversed(range(newest - lag, newest)):
        dt, here = times[k + 1] - times[k], filtered[k]
        x_minus, P_minus = predict(here.mean, here.covariance, F(dt), Q(dt))
        gain = np.linalg.solve(P_minus, F(dt) @ here.covariance).T
        x = here.mean + gain @ (x - x_minus)
        P = here.covariance + gain @ (P - P_minus) @ gain.T
    return x, P
