"""A gyroscope's bias: its mean rate while it is still."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array


@dataclass(frozen=True, eq=False)
class RateFit:
    """What still stretches say of a gyroscope.

    Parameters
    ----------
    bias : (n_axes,) rad/s
    std : (n_axes,) its deviation, by noise or by how the stretches differ, whichever is larger
    spread_std : (n_axes,) by how much the bias differs between stretches beyond their noise
    """

    bias: Array
    std: Array
    spread_std: Array


def fit_rate(means: Array, variances: Array) -> RateFit:
    """Return the mean over stretches, weighted by how well each is known.

    Parameters
    ----------
    means, variances : (p, n_axes) of p stretches
    """
    weights = 1 / variances
    bias = (weights * means).sum(axis=0) / weights.sum(axis=0)
    spare = max(len(means) - 1, 1)
    inflation = np.maximum(1.0, (weights * (means - bias) ** 2).sum(axis=0) / spare)
    excess = np.mean((means - bias) ** 2, axis=0) * len(means) / spare - variances.mean(axis=0)
    return RateFit(bias, np.sqrt(inflation / weights.sum(axis=0)), np.sqrt(np.maximum(excess, 0.0)))
