"""Of which earlier instants a window is asked: lags in samples, which are stages of the window."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from models.arrays import is_whole
from models.errors import InputError


def checked_lags(given: int | Sequence[int], horizon: int) -> tuple[int, ...]:
    """Return the lags, ascending, without 0: that is the plain estimate.

    Raises
    ------
    InputError
        If one is no whole number, or reaches further back than the window.
    """
    several = isinstance(given, Sequence | np.ndarray) and not isinstance(given, str)
    lags: list[Any] = list(given) if several else [given]  # type: ignore[arg-type]
    for lag in lags:
        if not (is_whole(lag) and lag >= 0):
            raise InputError(f"lag_samples is {given!r}, expected whole numbers of at least 0")
        if lag > horizon:
            raise InputError(
                f"a lag of {lag} samples is longer than the window's horizon, expected at most "
                f"{horizon}, or a longer horizon"
            )
    return tuple(sorted({int(lag) for lag in lags} - {0}))
