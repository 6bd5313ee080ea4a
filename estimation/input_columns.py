"""Columns of known inputs in a recording: what they may hold, and what acts where one is empty."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from estimation.reading_columns import check_mapping
from models.arrays import Array, numbers
from models.errors import InputError
from models.names import expected_one_of


def given_inputs(where: str, time_s: Array, given: Mapping[str, Any]) -> dict[str, Array]:
    """Return inputs (n,) by name, NaN where one is as before; a number stays for all instants.

    Parameters
    ----------
    where : ``recording run 3``

    Raises
    ------
    InputError
        If they are no mapping, have another shape, or are infinite.
    """
    expected = f"{time_s.shape} of numbers, NaN where it is as before"
    check_mapping(given, f"{where}: inputs", f"name → {expected}")
    found = {}
    for name, values in given.items():
        column = numbers(values, f"{where}: input {name}", expected)
        column = np.full(time_s.shape, column) if column.ndim == 0 else column
        if column.shape != time_s.shape or np.isinf(column).any():
            raise InputError(
                f"{where}: input {name} has values of shape {np.shape(values)}, expected {expected}"
            )
        found[name] = column
    return found


def held(recording: str, time_s: Array, inputs: Mapping[str, Array], name: str) -> Array:
    """Return an input (n,), held where it is missing.

    Raises
    ------
    InputError
        If there is none, or it is not known from the first instant on.
    """
    if name not in inputs:
        raise InputError(
            f"recording {recording} has no input {name}; {expected_one_of(name, inputs)}"
        )
    values = np.asarray(inputs[name], dtype=float)
    if np.isnan(values[0]):
        raise InputError(
            f"recording {recording}: input {name} has no value at the first instant "
            f"({time_s[0]:g} s), expected one: only a later one may be missing"
        )
    last = np.maximum.accumulate(np.where(np.isnan(values), 0, np.arange(len(values))))
    return values[last]
