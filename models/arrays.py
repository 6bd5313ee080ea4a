"""The array type of the project, double precision, and what people give instead."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from models.errors import InputError

Array = NDArray[np.float64]
ArrayT = TypeVar("ArrayT", bound=NDArray[Any])


def fixed(array: ArrayT) -> ArrayT:
    """Return an array that nobody can write to from now on."""
    array.flags.writeable = False
    return array


def arrays_within(value: Any) -> Iterator[NDArray[Any]]:
    """Go through all arrays inside nested dataclasses and tuples."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from arrays_within(item)
    elif is_dataclass(value):
        for field in fields(value):
            yield from arrays_within(getattr(value, field.name))


def numbers(given: Any, what: str, expected: str) -> Array:
    """Return numbers, lists of them or a pandas object as an array; NaN where there is None.

    Parameters
    ----------
    what : they are: ``readings of ruler``
    expected : of them: ``(n,) seconds``

    Raises
    ------
    InputError
        If they are no numbers, or lists of different lengths.
    """
    if isinstance(given, np.ndarray) and given.dtype == np.float64:
        return given
    try:
        found = np.asarray(given)
        if found.dtype.kind in "mMcSU":  # dates become nanoseconds, complex numbers lose a part
            raise TypeError
        return np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError):
        kind = type(given).__name__
        raise InputError(f"{what}: {kind} that holds no numbers, expected {expected}") from None
