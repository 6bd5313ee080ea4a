"""The array type of the project, double precision, and what people give instead."""

from __future__ import annotations

from numbers import Real
from typing import Any, TypeGuard, TypeVar

import numpy as np
from numpy.typing import NDArray

from models.errors import InputError

Array = NDArray[np.float64]
ArrayT = TypeVar("ArrayT", bound=NDArray[Any])


def fixed(array: ArrayT) -> ArrayT:
    """Return an array that nobody can write to from now on."""
    array.flags.writeable = False
    return array


def numbers(given: Any, what: str, expected: str) -> Array:
    """Return numbers, lists of them or a pandas object as an array; NaN where there is None.

    So it is where an array is masked: what lies beneath a mask is no reading.

    Parameters
    ----------
    what : they are: ``readings of ruler``
    expected : of them: ``(n,) seconds``

    Raises
    ------
    InputError
        If they are no numbers, or lists of different lengths.
    """
    if type(given) is np.ndarray and given.dtype == np.float64:
        return given
    if isinstance(given, np.ma.MaskedArray):
        return np.where(given.mask, np.nan, numbers(given.data, what, expected))
    try:
        found = np.asarray(given)
        if found.dtype.kind in "mMcSU":  # dates become nanoseconds, complex numbers lose a part
            raise TypeError
        return np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError):
        kind = type(given).__name__
        raise InputError(f"{what}: {kind} that holds no numbers, expected {expected}") from None


def is_real(given: object) -> bool:
    """Whether a setting is a real number; a truth value or a text is none."""
    return isinstance(given, Real) and not isinstance(given, bool | np.bool_)


def is_whole(given: object) -> TypeGuard[int]:
    """Whether a setting is a whole number; a truth value is none."""
    return isinstance(given, int | np.integer) and not isinstance(given, bool)


def keep_arrays(value: Any) -> None:
    """Give a frozen value arrays of its own that nobody can change.

    What is made of it is made once: a number that changed later would hold for some parts only.
    """
    for name, part in vars(value).items():
        if isinstance(part, np.ndarray):
            object.__setattr__(value, name, fixed(part.copy()))
