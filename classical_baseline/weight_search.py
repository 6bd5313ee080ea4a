"""The weight of `classical_baseline.fixed_weight`: bisection on the sign of dRMSE/dw.

    dRMSE/dw ≈ (RMSE(w + h) - RMSE(w - h)) / 2h

Below the best weight the slope is negative, above it positive. As published, the interval
is [0, 1]; where the slope has one sign at both of its ends, bisection can only walk to one
of them, and that bound says nothing of the best weight. The curve beyond shows it.

References
----------
[Tilt], its search for the weight.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from models.arrays import Array
from models.errors import InputError

Rmse = Callable[[float], float]
"""w → RMSE of what the filter says with this weight."""

INTERVAL = (0.0, 1.0)
"""As published."""

CURVE_WEIGHTS: tuple[float, ...] = (
    0.0,
    0.1,
    0.25,
    0.5,
    0.75,
    *(float(w) for w in np.round(np.geomspace(1.0, 300.0, 34), 2)),
)
"""Weights of a curve: the published interval, and on to 300 in steps of a fifth."""


class Ended(Enum):
    """How a search ended; the value says it."""

    INSIDE = "the slope changes its sign at the weight"
    LOWER_BOUND = "ended at the lower bound: the error grows with the weight from there on"
    UPPER_BOUND = "ended at the upper bound: the error still falls there, the best is beyond"

    @property
    def at_bound(self) -> bool:
        """Whether the interval, not the error, decided."""
        return self is not Ended.INSIDE


@dataclass(frozen=True)
class WeightSearch:
    """What a search found.

    Parameters
    ----------
    weight : where it ended
    rmse : there
    slope : there, dRMSE/dw
    ended : whether the weight is an optimum, or a bound of the interval
    evaluations : number of runs of the filter
    """

    weight: float
    rmse: float
    slope: float
    ended: Ended
    evaluations: int


def search_weight(
    rmse: Rmse,
    low: float = INTERVAL[0],
    high: float = INTERVAL[1],
    tolerance: float = 1e-3,
    difference: float = 1e-4,
) -> WeightSearch:
    """Return the weight in an interval at which dRMSE/dw changes its sign from - to +.

    Parameters
    ----------
    rmse : of a weight
    low, high : the interval
    tolerance : width of the interval that is narrow enough; smaller takes more runs
    difference : h; smaller has less error of its own and more of rounding. At the ends of
        the interval the centre of the difference lies h inside

    Raises
    ------
    InputError
        If the interval is empty or negative, or tolerance or difference do not fit into it.
    """
    if not 0 <= low < high < math.inf:
        raise InputError(f"interval of the weight is {low} to {high}, expected 0 <= low < high")
    if not 0 < tolerance < high - low:
        raise InputError(
            f"tolerance is {tolerance}, expected between 0 and the interval's {high - low}"
        )
    if not 0 < difference <= (high - low) / 4:
        raise InputError(
            f"difference is {difference}, expected up to a quarter of the interval's {high - low}"
        )
    runs, first, last = 0, low, high

    def counted(weight: float) -> float:
        nonlocal runs
        runs += 1
        return rmse(weight)

    def slope(weight: float) -> float:
        centre = min(max(weight, first + difference), last - difference)
        upper, lower = counted(centre + difference), counted(centre - difference)
        return (upper - lower) / (2 * difference)

    def found(weight: float, ended: Ended) -> WeightSearch:
        at, steepness = counted(weight), slope(weight)
        return WeightSearch(weight, at, steepness, ended, runs)

    if slope(low) >= 0:
        return found(low, Ended.LOWER_BOUND)
    if slope(high) <= 0:
        return found(high, Ended.UPPER_BOUND)
    while high - low > tolerance:
        middle = (low + high) / 2
        if slope(middle) < 0:
            low = middle
        else:
            high = middle
    return found((low + high) / 2, Ended.INSIDE)


def weight_curve(rmse: Rmse, weights: Sequence[float] = CURVE_WEIGHTS) -> Array:
    """Return the RMSE (n,) of n weights."""
    return np.array([rmse(weight) for weight in weights])


def best_weight(weights: Sequence[float], errors: Array) -> float:
    """Return the weight of the smallest RMSE of a curve: the smaller one of equal ones.

    Raises
    ------
    InputError
        If there are no weights, or not one error for each.
    """
    if not len(weights) or errors.shape != (len(weights),):
        raise InputError(
            f"{len(weights)} weights and errors of shape {errors.shape}, "
            "expected one error for each of at least one weight"
        )
    return float(weights[int(np.argmin(errors))])
