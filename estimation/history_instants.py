"""A history by instants: rows of some times, and one row each where a time is told again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

import numpy as np

from estimation.history_rows import first_rows
from models.arrays import Array
from models.errors import InputError


class AtInstants:
    """Rows by time; the arrays are `estimation.history.EstimateHistory`'s."""

    if TYPE_CHECKING:
        time_s: Array

        def __getitem__(self, rows: Any) -> Self: ...

    def at(self, time_s: Array) -> Self:
        """Return the estimates at some of the instants, given exactly.

        Where an instant is told again, as late readings of it or before it arrive, it is the row
        told first: it knows what had arrived when the instant became the newest, and no more.

        Raises
        ------
        InputError
            If there is no estimate at one of them.
        """
        time_s = np.atleast_1d(np.asarray(time_s, dtype=float))
        there = np.isin(time_s, self.time_s)
        if not there.all():
            missing = time_s[~there][0]
            raise InputError(f"no estimate at {missing:g} s, expected one of the run's instants")
        first = first_rows(self.time_s)
        return self[first[np.searchsorted(self.time_s[first], time_s)]]

    def between(self, start_s: float = -np.inf, end_s: float = np.inf) -> Self:
        """Return the estimates from one instant to another, both included.

        An end before the start raises `InputError`.
        """
        if not start_s <= end_s:
            raise InputError(f"from {start_s:g} s to {end_s:g} s, expected an end after the start")
        return self[(self.time_s >= start_s) & (self.time_s <= end_s)]

    def first_told(self) -> Self:
        """Return one row per instant, in order of time: the one told first, see `at`."""
        return self[first_rows(self.time_s)]
