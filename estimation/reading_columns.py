"""Times and readings of a recording as people give them: arrays, lists or pandas objects."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from models.arrays import Array, numbers
from models.errors import InputError


def given_times(where: str, given: Any) -> Array:
    """Return times (n,) in s.

    Parameters
    ----------
    where : ``recording run 3``

    Raises
    ------
    InputError
        If there are none, or they are not finite or do not increase.
    """
    time_s = numbers(given, f"{where}: times", "(n,) seconds")
    if time_s.ndim != 1:
        raise InputError(f"{where}: times have shape {time_s.shape}, expected (n,) seconds")
    if len(time_s) == 0:
        raise InputError(f"{where} is empty, expected at least one sample")
    if not np.isfinite(time_s).all():
        row = int(np.flatnonzero(~np.isfinite(time_s))[0])
        raise InputError(f"{where}: time of row {row} is not finite")
    steps = np.diff(time_s)
    if (steps <= 0).any():
        row = int(np.flatnonzero(steps <= 0)[0]) + 1
        raise InputError(
            f"{where}: time of row {row} ({time_s[row]:g} s) does not "
            f"follow the one before ({time_s[row - 1]:g} s), expected increasing times"
        )
    return time_s


def check_mapping(given: object, what: str, expected: str) -> None:
    """Raise `InputError` unless columns are given by name.

    Parameters
    ----------
    what : what they are, in the plural: ``recording run 3: readings``
    """
    if not isinstance(given, Mapping):
        raise InputError(f"{what} are a {type(given).__name__}, expected {expected}")


def _all_finite(values: Array) -> bool:
    """Whether all are numbers, which costs less than to look for infinity at each."""
    return not values.size or bool(np.isfinite([values.min(), values.max()]).all())


def given_readings(where: str, n: int, given: Mapping[str, Any]) -> dict[str, Array]:
    """Return readings (n, n_y) by sensor; (n,) are those of one axis.

    Raises
    ------
    InputError
        If they are no mapping, have another shape, or are infinite.
    """
    check_mapping(given, f"{where}: readings", "sensor name → (n, n_y) numbers")
    found = {}
    for sensor, values in given.items():
        readings = numbers(values, f"{where}: readings of {sensor}", f"({n}, n) numbers")
        readings = readings[:, None] if readings.ndim == 1 else readings
        if readings.ndim != 2 or len(readings) != n:
            raise InputError(
                f"{where}: readings of {sensor} have shape {np.shape(values)}, expected ({n}, n)"
            )
        if not _all_finite(readings) and np.isinf(readings).any():
            row = int(np.argwhere(np.isinf(readings))[0, 0])
            raise InputError(
                f"{where}: {sensor} in row {row} is infinite, "
                "expected a number, or NaN where there is no reading"
            )
        found[sensor] = readings
    return found


def given_columns(where: str, given: Mapping[str, Any]) -> dict[str, tuple[Array, Array]]:
    """Return (times (n,), values (n, n_y)) by sensor or input, each with times of its own.

    Raises
    ------
    InputError
        If one is no such pair.
    """
    found = {}
    for name, pair in given.items():
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise InputError(
                f"{where}: {name} is of type {type(pair).__name__}, expected (times, values)"
            )
        times = numbers(pair[0], f"{where}: times of {name}", "(n,) seconds")
        values = numbers(pair[1], f"{where}: values of {name}", f"({np.size(times)}, n) numbers")
        values = values[:, None] if values.ndim == 1 else values
        if times.ndim != 1 or values.ndim != 2 or len(values) != len(times):
            raise InputError(
                f"{where}: {np.size(times)} times of {name} for values of shape "
                f"{np.shape(pair[1])}, expected ({np.size(times)}, n)"
            )
        found[name] = (times, values)
    return found
