"""The rows that an estimator is given of a recording: in order of capture, or as they arrived.

In order of arrival every reading comes when it came, so nothing that a row holds, nor that there is
one, depends on what arrives later. What no sensor brings (a writing area's reading, known inputs)
goes with rows that are on time, those newer than all before.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from estimation.arrivals import arrival_of, has_reading
from estimation.input_columns import held
from estimation.intervals import check_intervals
from models.arrays import Array
from models.errors import InputError
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel


class Recorded(Protocol):
    """A recording, as `estimation.recording.Recording` describes it."""

    @property
    def name(self) -> str:
        """For people."""

    @property
    def time_s(self) -> Array:
        """(n,)"""

    @property
    def readings(self) -> Mapping[str, Array]:
        """Sensor → (n, n_y)."""

    @property
    def inputs(self) -> Mapping[str, Array]:
        """Name → (n,)."""

    @property
    def arrivals(self) -> Mapping[str, Array]:
        """Sensor → (n,)."""

    def sensor(self, name: str) -> tuple[Array, Array]:
        """Times and readings of a sensor that there is; `InputError` for an unknown one."""


def in_order_of_capture(
    recording: Recorded, model: StateSpaceModel, *, constants: ConstantReadings | None = None
) -> tuple[Array, Array]:
    """Return times (n,) and rows (n, n_row); see `estimation.recording.Recording.stacked`.

    Parameters
    ----------
    constants : what constant readings were told before, where the recording goes on
    """
    time_s = recording.time_s
    y = np.full((len(time_s), model.n_row), np.nan)
    for sensor, columns in _told_sensors(recording, model):
        y[:, columns] = recording.readings[sensor.name]
    (constants or ConstantReadings(model)).tell(time_s, y, np.arange(len(time_s)))
    for i, name in enumerate(model.input_names, model.n_y):
        y[:, i] = held(recording.name, time_s, recording.inputs, name)
    return np.asarray(time_s, dtype=float), y


def in_order_of_arrival(
    recording: Recorded,
    model: StateSpaceModel,
    *,
    until_s: float = np.inf,
    constants: ConstantReadings | None = None,
) -> tuple[Array, Array, Array]:
    """Return times (n,), rows (n, n_row) and arrivals (n,); see `Recording.as_arrived`.

    Parameters
    ----------
    until_s : what arrives later is left out
    constants : what constant readings were told before, where the recording goes on

    Raises
    ------
    InputError
        If no sensor has a reading, or an input is not known from the first instant on.
    """
    time_s, sensors = recording.time_s, list(_told_sensors(recording, model))
    inputs = [
        (held(recording.name, time_s, recording.inputs, name), recording.inputs[name])
        for name in model.input_names
    ]
    captured, arrived = [], []
    for sensor, _ in sensors:
        rows = np.flatnonzero(has_reading(recording.readings[sensor.name]))
        captured.append(rows)
        arrived.append(arrival_of(time_s, recording.arrivals, sensor)[rows])
    if inputs:  # known at their instant
        rows = np.flatnonzero(np.any([~np.isnan(given) for _, given in inputs], axis=0))
        captured.append(rows)
        arrived.append(time_s[rows])
    pairs = np.column_stack([np.concatenate(arrived), np.concatenate(captured)])
    if not len(pairs):
        raise InputError(
            f"recording {recording.name}: no sensor of {model.name} has a reading, expected one "
            "that arrives"
        )
    groups, group = np.unique(pairs, axis=0, return_inverse=True)
    arrival_s, row = groups[:, 0], groups[:, 1].astype(int)
    starts = np.cumsum([0, *map(len, captured)])
    y = np.full((len(groups), model.n_row), np.nan)
    for (sensor, columns), rows, start in zip(sensors, captured, starts[:-1], strict=False):
        y[group.ravel()[start : start + len(rows)], columns] = recording.readings[sensor.name][rows]
    end = int(np.searchsorted(arrival_s, until_s, side="right"))
    row, y, arrival_s = row[:end], y[:end], arrival_s[:end]
    told = constants or ConstantReadings(model)
    newest = np.maximum.accumulate(np.append(told.newest_s, time_s[row]))
    on_time = np.flatnonzero(np.diff(newest) > 0)
    told.tell(time_s[row], y, on_time)
    for i, (values, _) in enumerate(inputs, model.n_y):
        y[on_time, i] = values[row[on_time]]
    return time_s[row], y, arrival_s


def check_sensors(recording: Recorded, model: StateSpaceModel) -> None:
    """Raise `InputError` unless a recording has what a model's sensors read."""
    check_intervals(recording.name, recording.time_s, model)
    own = [s for s in model.sensors if s.rest is not None and s.name in recording.readings]
    for sensor in (*model.measured_sensors, *own):
        if sensor.name not in recording.readings:
            recording.sensor(sensor.name)  # raises
        width = recording.readings[sensor.name].shape[1]
        if width != sensor.n_y:
            raise InputError(
                f"recording {recording.name}: {sensor.name} has {width} columns, "
                f"expected {sensor.n_y} ({', '.join(sensor.axes)})"
            )


def _columns(model: StateSpaceModel) -> list[tuple[SensorModel, slice]]:
    ends = np.cumsum([sensor.n_y for sensor in model.sensors]).tolist()
    return [(s, slice(end - s.n_y, end)) for s, end in zip(model.sensors, ends, strict=True)]


def _told_sensors(recording: Recorded, model: StateSpaceModel) -> list[tuple[SensorModel, slice]]:
    """Return the sensors whose readings a recording has; rest where an IMU tells it."""
    return [
        (sensor, columns)
        for sensor, columns in _columns(model)
        if sensor.constant_reading is None and sensor.name in recording.readings
    ]


class ConstantReadings:
    """What no sensor brings, told at the first instant of each of its periods, and only once.

    Its `newest_s` is the last instant that was on time, -inf before the first.
    """

    def __init__(self, model: StateSpaceModel) -> None:
        self._first_s, self.newest_s = np.nan, -np.inf
        constant = {
            s.name: s.constant_reading for s in model.sensors if s.constant_reading is not None
        }
        self._constant = model.stack(constant)
        self._sensors = [(s, at) for s, at in _columns(model) if s.name in constant]

    def tell(self, time_s: Array, y: Array, on_time: NDArray[np.integer]) -> None:
        """Write constant readings into rows (n, n_row), those on time by their numbers."""
        times = time_s[on_time]
        if not len(times):
            return
        behind = None if np.isnan(self._first_s) else (self._first_s, self.newest_s)
        for sensor, columns in self._sensors:
            rows = on_time[sensor.first_of_each_period(times, behind=behind)]
            y[rows, columns] = self._constant[columns]
        self._first_s = float(times[0]) if behind is None else self._first_s
        self.newest_s = float(times[-1])
