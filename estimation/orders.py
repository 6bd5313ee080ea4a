"""A recording that comes in parts, stacked as the whole of it would be.

In order of arrival a part tells what has arrived by its last instant: whatever is captured later
arrives later. The rest waits for the next part.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from estimation.arrivals import arrival_of, has_reading
from estimation.recording import Recording
from estimation.recording_parts import joined
from estimation.stacking import (
    ConstantReadings,
    check_sensors,
    in_order_of_arrival,
    in_order_of_capture,
)
from models.arrays import Array
from models.limits import check_most
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class Stacked:
    """Rows for an estimator: times (n,), rows (n, n_row), and arrivals (n,); see `Recording`."""

    time_s: Array
    y: Array
    arrival_s: Array

    def __len__(self) -> int:
        return len(self.time_s)


def no_rows(model: StateSpaceModel) -> Stacked:
    """Return none of a model's rows."""
    return Stacked(np.zeros(0), np.zeros((0, model.n_row)), np.zeros(0))


class InOrderOfCapture:
    """Rows by their capture, of a model without inputs; see `Recording.stacked`."""

    def __init__(self, model: StateSpaceModel) -> None:
        self.model, self._constants = model, ConstantReadings(model)

    def take(self, part: Recording) -> Stacked:
        """Return the rows of the next part."""
        check_sensors(part, self.model)
        time_s, y = in_order_of_capture(part, self.model, constants=self._constants)
        return Stacked(time_s, y, time_s)

    def end(self) -> Stacked:
        """Return the rows behind the last part: none."""
        return no_rows(self.model)


class InOrderOfArrival:
    """Rows as they arrive, of a model without inputs; see `Recording.as_arrived`."""

    def __init__(self, model: StateSpaceModel) -> None:
        self.model, self._constants = model, ConstantReadings(model)
        self._waiting: Recording | None = None

    def take(self, part: Recording) -> Stacked:
        """Return the rows that have arrived by the last instant of the next part.

        Raises
        ------
        InputError
            If more instants than `models.limits.LIMITS` allows wait for their arrival.
        """
        check_sensors(part, self.model)
        known = part if self._waiting is None else joined([self._waiting, part])
        return self._arrived(known, float(part.time_s[-1]))

    def end(self) -> Stacked:
        """Return the rows that arrive after the last instant."""
        if self._waiting is None:
            return no_rows(self.model)
        return self._arrived(self._waiting, np.inf)

    def _arrived(self, known: Recording, until_s: float) -> Stacked:
        rows = in_order_of_arrival(known, self.model, until_s=until_s, constants=self._constants)
        self._waiting = _later(known, self.model, until_s)
        if self._waiting is not None:
            waiting = len(self._waiting.time_s)
            check_most("waiting_rows", waiting, f"recording {known.name}")
        return Stacked(*rows)


def _later(known: Recording, model: StateSpaceModel, until_s: float) -> Recording | None:
    """Return the readings that arrive after an instant; None where there are none."""
    readings, waits = {}, np.zeros(len(known.time_s), dtype=bool)
    for sensor in model.sensors:
        if sensor.name in known.readings:
            values = known.readings[sensor.name]
            late = arrival_of(known.time_s, known.arrivals, sensor) > until_s
            readings[sensor.name] = np.where(late[:, None], values, np.nan)
            waits |= late & has_reading(values)
    if not waits.any():
        return None
    return dataclasses.replace(known, readings=readings, truth=None).some_rows(waits)
