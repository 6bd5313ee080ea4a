"""Rows as they reach an estimator: what a recording cannot hold, stamps twice or going back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from estimation.arrivals import has_reading
from estimation.recording import Recording
from estimation.stacking import in_order_of_capture
from models.arrays import Array
from models.frozen_mapping import FrozenMapping
from models.state_space import StateSpaceModel
from models.units import TIME_DIGITS


@dataclass(frozen=True, eq=False)
class GivenRows:
    """Readings row by row, in the order in which an estimator gets them.

    Parameters
    ----------
    time_s : (n,) stamps, s, in any order, and two may be one
    readings : sensor → (n, n_y), NaN where there is none
    """

    time_s: Array
    readings: Mapping[str, Array]
    name: str = "with a fault"
    inputs: Mapping[str, Array] = field(default_factory=FrozenMapping)
    arrivals: Mapping[str, Array] = field(default_factory=FrozenMapping)

    @classmethod
    def of(cls, recording: Recording) -> GivenRows:
        """Return a recording's rows in order of capture."""
        return cls(recording.time_s, recording.readings)

    @classmethod
    def merged(cls, sensors: Mapping[str, tuple[Array, Array]]) -> GivenRows:
        """Return the rows of sensors with stamps (n,) of their own, each of them once."""
        stamps = {name: np.round(times, TIME_DIGITS) for name, (times, _) in sensors.items()}
        time_s = np.unique(np.concatenate(list(stamps.values())))
        readings = {}
        for name, (_, values) in sensors.items():
            readings[name] = np.full((len(time_s), values.shape[1]), np.nan)
            readings[name][np.searchsorted(time_s, stamps[name])] = values
        return cls(time_s, readings)

    def sensor(self, name: str) -> tuple[Array, Array]:
        """Return stamps and readings of a sensor where it has any."""
        rows = self.rows_of(name)
        return self.time_s[rows], self.readings[name][rows]

    def rows_of(self, name: str) -> NDArray[np.int64]:
        """Return the rows in which a sensor has a reading."""
        return np.flatnonzero(has_reading(self.readings[name]))

    def changed(self, name: str, rows: NDArray[np.int64], values: Array) -> GivenRows:
        """Return the same but for some readings of a sensor, (k, n_y) in k rows."""
        whole = self.readings[name].copy()
        whole[rows] = values
        return GivenRows(self.time_s, {**self.readings, name: whole})

    def taken(self, rows: NDArray[np.int64]) -> GivenRows:
        """Return some rows, in the order given."""
        readings = {name: values[rows] for name, values in self.readings.items()}
        return GivenRows(self.time_s[rows], readings)

    def stacked(self, model: StateSpaceModel) -> tuple[Array, Array]:
        """Return stamps (n,) and what a model's estimator is given of each row, (n, n_row)."""
        return in_order_of_capture(self, model)
