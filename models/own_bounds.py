"""Bounds on the states of a model of one's own."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.model_checks import check_bound

Bound = tuple[float | None, float | None]
"""(lower, upper); None or an infinity where there is none."""


def own_bounds(
    model: str, states: tuple[str, ...], bounds: Mapping[str, Bound]
) -> tuple[Array, Array]:
    """Return lower and upper (n_x,) of bounds given by name, ±inf where there is none.

    Parameters
    ----------
    model : its name
    states : (n_x,) names

    Raises
    ------
    InputError
        If a state is unknown, or a bound is no pair of numbers or holds no value between them.
    """
    lower, upper = np.full(len(states), -np.inf), np.full(len(states), np.inf)
    for state, bound in bounds.items():
        low, high = _pair(model, state, bound)
        check_bound(model, states, state, (low, high))
        lower[states.index(state)], upper[states.index(state)] = low, high
    return lower, upper


def _pair(model: str, state: str, bound: Bound) -> tuple[float, float]:
    try:
        low, high = bound
        return -np.inf if low is None else float(low), np.inf if high is None else float(high)
    except (TypeError, ValueError):
        raise InputError(
            f"model {model}: bound on {state} is {bound!r}, "
            "expected (lower, upper), None where there is none"
        ) from None
