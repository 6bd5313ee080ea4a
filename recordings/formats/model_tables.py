"""Recordings of a model of one's own as tables: readings, known inputs and truth by name.

Columns are ``time_s`` (or another unit of time), ``<sensor>_<axis>`` of every reading, an input's
own name, and ``true_<state>``; all in the model's units; ``<sensor>_arrival_s`` where readings
arrive later than they were captured. An empty cell is a sensor without a
reading, and an input that is as it was before. Other columns are refused.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from estimation.recording import Recording, Truth
from models.arrays import Array
from models.errors import InputError
from models.names import unknown
from models.state_space import StateSpaceModel
from models.units import TIME_DIGITS, UNITS
from recordings.formats.columns import ARRIVAL, TRUTH_PREFIX, increasing_times, numbers


def recording_from_model_table(table: pd.DataFrame, model: StateSpaceModel, name: str) -> Recording:
    """Turn a table into a recording of a model's sensors and inputs.

    Raises
    ------
    InputError
        If a column is missing or unknown, a cell is not a finite number, or times do not
        increase; the message names column and row.
    """
    where = f"recording {name}"
    headers = [str(header) for header in table.columns]
    times = [header for header in headers if header in _times()]
    states = [TRUTH_PREFIX + state for state in model.state_names]
    needed = [*_readings(model), *model.input_names]
    arrivals = {f"{sensor.name}_{ARRIVAL}_s": sensor.name for sensor in model.measured_sensors}
    for header in headers:
        if header not in (*_times(), *needed, *arrivals, *states):
            raise unknown(f"{where}: column", header, ("time_s", *needed, *states))
    missing = [header for header in needed if header not in headers]
    if len(times) != 1 or missing:
        lacking = missing[0] if missing else "time_s"
        raise InputError(f"{where}: column {lacking} is missing, expected {', '.join(needed)}")
    given = {header: numbers(table[header], where) for header in headers}
    time_s = increasing_times(given[times[0]] * _times()[times[0]], times[0], where)
    readings = {
        sensor.name: np.column_stack([given[f"{sensor.name}_{axis}"] for axis in sensor.axes])
        for sensor in model.measured_sensors
    }
    known = [state for state in states if state in headers]
    names = tuple(state.removeprefix(TRUTH_PREFIX) for state in known)
    values = [given[state] for state in known]
    truth = Truth(time_s, names, np.column_stack(values)) if known else None
    inputs = {key: given[key] for key in model.input_names}
    arrived = {
        sensor: np.round(given[header], TIME_DIGITS)
        for header, sensor in arrivals.items()
        if header in headers
    }
    return Recording(name, time_s, readings, truth, inputs, arrived)


def recording_to_model_table(recording: Recording, model: StateSpaceModel) -> pd.DataFrame:
    """Return a recording as a table that `recording_from_model_table` reads."""
    columns: dict[str, Array] = {"time_s": recording.time_s}
    for sensor in model.measured_sensors:
        for i, axis in enumerate(sensor.axes):
            columns[f"{sensor.name}_{axis}"] = recording.readings[sensor.name][:, i]
        if sensor.name in recording.arrivals:
            columns[f"{sensor.name}_{ARRIVAL}_s"] = recording.arrivals[sensor.name]
    columns |= {name: recording.inputs[name] for name in model.input_names}
    if recording.truth is not None:
        states = recording.truth.states(model.state_names, recording.time_s)
        for name, column in zip(model.state_names, states.T, strict=True):
            columns[TRUTH_PREFIX + name] = column
    return pd.DataFrame(columns)


def _readings(model: StateSpaceModel) -> list[str]:
    return [f"{sensor.name}_{axis}" for sensor in model.measured_sensors for axis in sensor.axes]


def _times() -> dict[str, float]:
    return {f"time_{unit}": factor for unit, factor in UNITS["s"].items()}
