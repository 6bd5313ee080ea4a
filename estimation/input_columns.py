"""Columns of known inputs in a recording: what they may hold, and what acts where one is empty."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.names import expected_one_of


def check_inputs(recording: str, time_s: Array, inputs: Mapping[str, Array]) -> None:
    """Raise `InputError` unless every input is (n,) numbers, NaN where it is as before."""
    for name, values in inputs.items():
        if values.shape != time_s.shape or np.isinf(values).any():
            raise InputError(
                f"recording {recording}: input {name} has values of shape {values.shape}, "
                f"expected {time_s.shape} of numbers, NaN where it is as before"
            )


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
