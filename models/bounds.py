"""Bounds by name: on states as they are, on other outputs as inequalities."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

import casadi as ca

from models.arrays import Array
from models.model_checks import check_bound
from models.outputs import Outputs

Rows = Callable[[ca.SX], ca.SX]
"""(x) -> expressions that have to be ≤ 0."""


class Bounded(Protocol):
    """What is bounded; see `models.state_space.StateSpaceModel`."""

    @property
    def name(self) -> str:
        """For people."""

    @property
    def state_names(self) -> tuple[str, ...]:
        """(n_x,)"""

    @property
    def outputs(self) -> Outputs | None:
        """None where people read the states."""


def split_bounds(
    model: Bounded,
    bounds: Mapping[str, tuple[float, float]],
    *,
    lower: Array,
    upper: Array,
) -> list[Rows]:
    """Write bounds on states into lower and upper (n_x,); return the inequalities of the others.

    Parameters
    ----------
    bounds : name → (lower, upper)

    Raises
    ------
    InputError
        If a name is unknown, or a bound is empty.
    """
    state_names, outputs = model.state_names, model.outputs
    known = tuple(dict.fromkeys((*state_names, *(outputs.names if outputs else ()))))
    rows = []
    for name, (low, high) in bounds.items():
        check_bound(model.name, known, name, (low, high))
        if name in state_names:
            index = state_names.index(name)
            lower[index], upper[index] = low, high
        elif outputs is not None:
            rows.append(outputs.bound(name, low, high))
    return rows
