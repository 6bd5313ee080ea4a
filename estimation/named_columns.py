"""A history by the names that people read: states, and outputs that are derived from them."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from estimation.recording import Truth
from models.arrays import Array
from models.names import unknown
from models.outputs import Outputs
from models.units import unit_ending

TURN = 2 * np.pi


class NamedColumns:
    """What a history says by name; the arrays are `estimation.history.EstimateHistory`'s."""

    if TYPE_CHECKING:
        state_names: tuple[str, ...]
        state_units: tuple[str, ...]
        derived_names: tuple[str, ...]
        time_s: Array
        mean: Array
        std: Array
        derived: Array
        derived_std: Array
        outputs: Outputs | None
        difference: ca.Function | None

    @abstractmethod
    def __len__(self) -> int:
        """Return the number of steps."""

    @property
    def names(self) -> tuple[str, ...]:
        """(n_o,) names of what people read: the model's outputs, or its states."""
        return self.state_names if self.outputs is None else self.outputs.names

    @property
    def values(self) -> Array:
        """(n, n_o) estimates of `names`, in the units of `unit_of`."""
        if self.outputs is None:
            return self.mean
        return np.column_stack([self.column(name) for name in self.names])

    @property
    def values_std(self) -> Array:
        """(n, n_o) standard deviations of `values`."""
        if self.outputs is None:
            return self.std
        return np.column_stack([self.std_of(name) for name in self.names])

    def column(self, name: str) -> Array:
        """Return the estimates (n,) of an output or a state; `InputError` for an unknown one."""
        if name in self.derived_names:
            return self.derived[:, self.derived_names.index(name)]
        return self.mean[:, self._state(name)]

    def std_of(self, name: str) -> Array:
        """Return the standard deviations (n,) of an output or a state, likewise.

        A state that has no name of its own in the tangent space (a component of an attitude)
        has that of the tangent vector's component.
        """
        if name in self.derived_names:
            return self.derived_std[:, self.derived_names.index(name)]
        return self.std[:, self._state(name)]

    def index(self, name: str) -> int:
        """Return which column of `values` a name has; `InputError` for an unknown one."""
        if name not in self.names:
            raise unknown("state", name, self.names)
        return self.names.index(name)

    def unit_of(self, name: str) -> str:
        """Return the unit of an output or a state, as people write it; `InputError` likewise."""
        if self.outputs is not None and name in self.outputs.names:
            return self.outputs.units[self.outputs.names.index(name)]
        index = self._state(name)
        return self.state_units[index] if self.state_units else unit_ending(name)

    def is_circular(self, name: str) -> bool:
        """Whether a turn more makes no difference to an output, by the model's own difference."""
        if self.outputs is not None:
            found = dict(zip(self.outputs.names, self.outputs.wrapped, strict=True))
            return found.get(name, False)
        if self.difference is None or name not in self.state_names or not len(self):
            return False
        x, turned = self.mean[0], self.mean[0].copy()
        turned[self.state_names.index(name)] += TURN
        moved = self.difference(turned, x).full().ravel()
        return bool(np.abs(moved).max() < 1e-6)

    def errors(self, truth: Truth) -> Array:
        """Return estimate minus truth (n, n_o), NaN for names that the truth does not have.

        Angles on the circle differ by the short way round.

        Raises
        ------
        InputError
            If an estimate's instant is not among the truth's.
        """
        true = truth.states(self.names, self.time_s)
        if self.outputs is not None:
            errors = self.values - true
            wrapped = np.array(self.outputs.wrapped)
            errors[:, wrapped] -= TURN * np.round(errors[:, wrapped] / TURN)
            return errors
        if self.difference is None or not len(self):  # CasADi makes one column of none
            return self.mean - true
        # One call for all instants: CasADi takes a column for each.
        return np.asarray(self.difference(self.mean.T, true.T).full().T)

    def _state(self, name: str) -> int:
        if name not in self.state_names:
            raise unknown("state", name, self.names)
        return self.state_names.index(name)
