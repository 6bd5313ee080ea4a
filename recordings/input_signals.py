"""Known inputs for a simulation: numbers, or functions of time."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from models.arrays import Array, numbers
from models.errors import InputError
from models.names import unknown
from models.state_space import StateSpaceModel

InputSignal = float | Callable[[Array], Array]
"""A number, or a function of times (n,) in s that returns (n,) values."""


def check_signals(model: StateSpaceModel, signals: Mapping[str, InputSignal]) -> None:
    """Raise `InputError` unless there is a signal for every input of a model, and no other."""
    if not isinstance(signals, Mapping):
        raise InputError(f"model {model.name}: inputs are {signals!r}, expected name → signal")
    for name in signals:
        if name not in model.input_names:
            raise unknown(f"model {model.name}: input", name, model.input_names)
    for name in model.input_names:
        if name not in signals:
            raise InputError(
                f"model {model.name}: input {name} is not given, "
                "expected a number or a function of times"
            )


def sampled(model: StateSpaceModel, signals: Mapping[str, InputSignal], time_s: Array) -> Array:
    """Return the inputs (n, n_u) at given instants.

    Raises
    ------
    InputError
        If a signal returns anything but (n,) numbers.
    """
    columns = np.zeros((len(time_s), model.n_u))
    for i, name in enumerate(model.input_names):
        signal = signals[name]
        given = signal(time_s) if callable(signal) else signal
        values = numbers(given, f"model {model.name}: input {name}", "a number or (n,) of them")
        if values.shape not in ((), time_s.shape) or not np.isfinite(values).all():
            raise InputError(
                f"model {model.name}: input {name} has values of shape {values.shape}, "
                f"expected {time_s.shape} finite numbers, one for each instant"
            )
        columns[:, i] = values
    return columns
