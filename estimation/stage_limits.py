"""How many digits a Kalman stage may lose before it does something about it."""

from __future__ import annotations

import numpy as np


def stage_limits(real: type[np.floating]) -> dict[str, float]:
    """Return how many digits a stage in C may lose before it does something about it.

    ``LOST``: a variance that falls, or grows, by more in one stage has lost a third of its digits
    to P - W Wᵀ, and the stage is made in square roots. ``BEYOND``: even these have two left.
    ``LEAST_SHARE``: of a variance, what is left at least when later readings are known too, for
    that is a difference.
    """
    eps = float(np.finfo(real).eps)
    return {"LOST": eps ** (-1 / 3), "BEYOND": (0.01 / eps) ** 2, "LEAST_SHARE": 512 * eps}
