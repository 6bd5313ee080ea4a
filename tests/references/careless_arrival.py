"""A smoothed arrival cost taken carelessly, on a random walk: the trap that ours must avoid.

    x⁺ = x + N(0, q),   y = x + N(0, r)

When the window drops its oldest stage, the prior of the first stage that stays becomes its
*smoothed* Gaussian, which knows the readings of the whole window. The window then uses those
readings once more.
"""

from __future__ import annotations

import numpy as np


def newest_variance(q: float, r: float, p0: float, horizon: int, steps: int) -> float:
    """Return the variance that the newest state then seems to have after some steps."""
    prior, newest = p0, np.nan
    for k in range(steps):
        n = min(k, horizon) + 1
        updated, predicted = [], [prior]
        for _ in range(n):
            updated.append(1 / (1 / predicted[-1] + 1 / r))
            predicted.append(updated[-1] + q)
        newest = updated[-1]
        if n <= horizon:
            continue
        smoothed = [newest]  # Rauch-Tung-Striebel, newest first
        for i in reversed(range(n - 1)):
            gain = updated[i] / predicted[i + 1]
            smoothed.append(updated[i] + gain**2 * (smoothed[-1] - predicted[i + 1]))
        prior = smoothed[-2]
    return newest
