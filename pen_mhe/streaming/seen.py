"""What a configuration can see along the truth of a recording that comes in parts."""

from __future__ import annotations

import numpy as np

from estimation.information_bound import BoundInParts
from estimation.observability import Verdict, start_rows, verdict_from
from estimation.orders import InOrderOfCapture
from estimation.recording import Recording
from estimation.truth import Truth
from models.arrays import Array
from models.state_space import StateSpaceModel


class SeenInParts:
    """`pen_mhe.sensor_verdict.judge` of a recording whose parts pass by.

    Parameters
    ----------
    instants : how many there will be
    """

    def __init__(self, model: StateSpaceModel, instants: int) -> None:
        self._model, self._order = model, InOrderOfCapture(model)
        self._bound, self._starts = BoundInParts(model), start_rows(instants)
        self._states: list[Array] = []
        self._instants, self._is_known = 0, True

    def take(self, used: Recording, truth: Truth) -> None:
        """Go on along the truth of the next part; where it has gaps there is no verdict."""
        rows = self._order.take(used)
        states = truth.states(self._model.state_names, rows.time_s)
        self._is_known = self._is_known and not np.isnan(states).any()
        if self._is_known:
            self._bound.add(rows.time_s, rows.y, states)
            end = self._instants + len(rows)
            here = self._starts[(self._starts >= self._instants) & (self._starts < end)]
            self._states += list(states[here - self._instants])
            self._instants = end

    def result(self) -> Verdict | None:
        """Return the verdict; None where a state of the model is not known at some instant."""
        if not self._is_known:
            return None
        no_inputs = [np.zeros(0)] * len(self._states)
        bound = self._bound.result()
        return verdict_from(self._model, np.array(self._states), no_inputs, bound)
