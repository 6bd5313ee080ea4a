"""What a history may be asked for by ``[…]``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.errors import InputError


def check_rows(rows: object, n: int) -> None:
    """Raise `InputError` unless these are a slice, numbers of steps, or bools (n,)."""
    if isinstance(rows, slice):
        ends = (rows.start, rows.stop, rows.step)
        is_good = all(end is None or isinstance(end, int | np.integer) for end in ends)
    elif isinstance(rows, np.ndarray):
        is_mask = rows.dtype.kind == "b" and rows.shape == (n,)
        is_good = is_mask or (rows.dtype.kind in "iu" and rows.ndim == 1)
    else:
        is_good = False
    if not is_good:
        raise InputError(
            f"a history was asked for [{rows!r}], expected a slice or an array of steps: one is "
            "history[k : k + 1], by time they are history.at(times) and history.between(start, end)"
        )


def first_rows(time_s: Array) -> NDArray[Any]:
    """Return the first row of each time, in order of time."""
    return np.asarray(np.unique(time_s, return_index=True)[1])
