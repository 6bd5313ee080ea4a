"""Bounds by name: on states as they are, on other outputs as inequalities."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import casadi as ca

from models.arrays import Array
from models.model_checks import check_bound
from models.outputs import Outputs

Rows = Callable[[ca.SX], ca.SX]
"""(x) -> expressions that have to be ≤ 0."""


def split_bounds(
    model: str,
    bounds: Mapping[str, tuple[float, float]],
    state_names: tuple[str, ...],
    outputs: Outputs | None,
    lower: Array,
    upper: Array,
) -> list[Rows]:
    """Write bounds on states into lower and upper (n_x,); return the inequalities of the others.

    Parameters
    ----------
    model : its name
    bounds : name → (lower, upper)

    Raises
    ------
    InputError
        If a name is unknown, or a bound is empty.
    """
    known = tuple(dict.fromkeys((*state_names, *(outputs.names if outputs else ()))))
    rows = []
    for name, (low, high) in bounds.items():
        check_bound(model, known, name, (low, high))
        if name in state_names:
            index = state_names.index(name)
            lower[index], upper[index] = low, high
        elif outputs is not None:
            rows.append(outputs.bound(name, low, high))
    return rows
