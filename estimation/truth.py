"""True states, where they are known: no estimator is given them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from models.arrays import Array, numbers
from models.errors import InputError
from models.names import several

TRUTH_TOLERANCE_S = 1e-6
"""How far from an instant the truth may be given to count as its truth."""


@dataclass(frozen=True, eq=False)
class Truth:
    """True states: times (n,), the names of the states and their values (n, k).

    Raises
    ------
    InputError
        If shapes do not fit together, or they are no numbers.
    """

    time_s: Array
    names: tuple[str, ...]
    values: Array

    def __post_init__(self) -> None:
        time_s = numbers(self.time_s, "times of the truth", "(n,) seconds")
        values = numbers(self.values, "values of the truth", "(n, k) numbers")
        names = several(self.names)
        if time_s.ndim != 1 or values.shape != (len(time_s), len(names)):
            raise InputError(
                f"the truth has times {time_s.shape} and values {values.shape} of {len(names)} "
                f"states, expected (n,) and (n, {len(names)})"
            )
        for name, given in (("time_s", time_s), ("names", names), ("values", values)):
            object.__setattr__(self, name, given)

    def states(self, names: Sequence[str], time_s: Array) -> Array:
        """Return true states (m, len(names)) at given instants, NaN for states it has not.

        Raises
        ------
        InputError
            If the truth is not given at one of the instants.
        """
        rows = np.minimum(np.searchsorted(self.time_s, time_s), len(self.time_s) - 1)
        before = np.maximum(rows - 1, 0)
        nearer = np.abs(self.time_s[before] - time_s) < np.abs(self.time_s[rows] - time_s)
        rows = np.where(nearer, before, rows)
        away = np.abs(self.time_s[rows] - time_s)
        if (away > TRUTH_TOLERANCE_S).any():
            raise InputError(
                f"no truth at {time_s[int(np.argmax(away))]:g} s, "
                "expected it at every instant of the estimates"
            )
        states = np.full((len(time_s), len(names)), np.nan)
        for column, name in enumerate(names):
            if name in self.names:
                states[:, column] = self.values[rows, self.names.index(name)]
        return states
