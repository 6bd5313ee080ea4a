"""Recordings and estimates as tables: CSV and Parquet.

A recording has a column ``time_s`` (or ``time_ms``, ``time_us``) and columns
``<sensor>_<axis>``, with the unit at the end of the header
(``accel_x_m_s2``, ``gyro_x_deg_s``) or given by option, else SI. ``<sensor>_arrival_s`` is when its
reading arrived, ``true_<state>`` the truth: in any unit of their row of `models.units`.

A Parquet file that is written says in its metadata with which version: ``pen_mhe_version``. A CSV
has no place for it that every reader would skip.

An empty cell is a sensor without a reading. A CSV that says ``nan`` or ``inf``
is refused; in Parquet an empty cell and NaN are the same.

Messages count rows of data from 1: row 1 is the one below the header.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd
import pyarrow.parquet

from estimation.arrivals import has_reading
from estimation.output_file import check_file, whole_file
from estimation.recording import Recording, Truth
from models.arrays import Array
from models.border import reading
from models.errors import InputError
from models.pen_config import PenConfig
from models.plain_names import plain_headers
from models.shown_text import short
from models.units import TIME_DIGITS
from models.version import version_metadata
from recordings.foreign.header_units import KNOWN_UNITS
from recordings.foreign.time_units import check_time_unit
from recordings.formats.arrow import read_arrow
from recordings.formats.columns import (
    ARRIVAL,
    TIME,
    TRUTH_PREFIX,
    Column,
    check_units_given,
    column_units,
    expected_for,
    increasing_times,
    numbers,
    recording_columns,
    spellings,
)
from recordings.formats.csv_files import check_header, read_csv
from recordings.plausible_units import check_units, spread
from recordings.written import WrittenRecording

TABLE_SUFFIXES = (".csv", ".parquet")


def read_table(path: Path) -> pd.DataFrame:
    """Read a CSV or Parquet file by its suffix.

    Raises
    ------
    InputError
        If the file cannot be read, or a column has no name or that of another.
    """
    where, kind = f"recording {path}", path.suffix[1:]
    if path.suffix not in TABLE_SUFFIXES:
        raise InputError(
            f"{where}: suffix {path.suffix or '(none)'} is unknown, "
            f"expected {', '.join(TABLE_SUFFIXES)}"
        )
    with reading(where, f"a {kind} table"):
        return _READERS[path.suffix](path, where)


def _read_parquet(path: Path, where: str) -> pd.DataFrame:
    table = read_arrow(path, where, "a parquet table")
    # Rows that pandas has counted or named are no quantity of a recording.
    kept = [i for i, name in enumerate(table.column_names) if not _PANDAS_INDEX.fullmatch(name)]
    table = table.select(kept)
    check_header(table.column_names, where)
    return table.to_pandas()


_PANDAS_INDEX = re.compile(r"__index_level_\d+__")
_READERS = MappingProxyType({".csv": read_csv, ".parquet": _read_parquet})


def check_output(path: Path, suffixes: Sequence[str] = TABLE_SUFFIXES) -> None:
    """Refuse a file that cannot be written before the work that would be lost; makes nothing.

    Raises
    ------
    InputError
        If the suffix is not one of `suffixes`, its folder does not exist, or it cannot be
        written.
    """
    if path.suffix not in suffixes:
        raise InputError(
            f"output {path}: suffix {path.suffix or '(none)'} is unknown, "
            f"expected {', '.join(suffixes)}"
        )
    check_file(path)


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table whole, as CSV or Parquet by its suffix; Parquet says with which version."""
    check_output(path)
    with whole_file(path) as file:
        if path.suffix == ".csv":
            table.to_csv(file, index=False)
            return
        arrow = pyarrow.Table.from_pandas(table, preserve_index=False)
        metadata = {**(arrow.schema.metadata or {}), **version_metadata()}
        pyarrow.parquet.write_table(arrow.replace_schema_metadata(metadata), file)


def load_table(
    path: Path, pen: PenConfig, *, units: Mapping[str, str] | None = None
) -> WrittenRecording:
    """Read a recording from a table whose units make sense; see `recording_from_table`."""
    table = read_table(path)
    known = recording_columns(pen, units or {})
    table.columns = pd.Index(plain_headers(list(table.columns), known, f"recording {path}"))
    table, notes = _without_silent(table, pen, known)
    recording = recording_from_table(table, pen, str(path), units=units)
    _check_time(table, recording, pen, known)
    check_units(recording, pen, read_as=column_units(table.columns, pen, units=units))
    return WrittenRecording(recording, notes=notes)


def _check_time(
    table: pd.DataFrame, recording: Recording, pen: PenConfig, known: Mapping[str, Column]
) -> None:
    """Refuse times in a unit in which no inertial sensor has such a rate."""
    header = next(header for header in table.columns if known[header].quantity == TIME)
    for sensor in recording.readings:
        if pen.sensors[sensor].feels_gravity or pen.sensors[sensor].reads_rate:
            rows = spread(len(recording.time_s))
            time_s = recording.time_s[rows][has_reading(recording.readings[sensor][rows])]
            unit = KNOWN_UNITS[known[header].unit]
            check_time_unit(header, unit, time_s, f"recording {recording.name}")


def _without_silent(
    table: pd.DataFrame, pen: PenConfig, known: Mapping[str, Column]
) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Leave out sensors that may be silent and were: a contact, while the tip touched nothing."""
    notes = []
    for sensor, config in pen.sensors.items():
        own = [f"{sensor}_{axis}" for axis, _ in config.reading_axes]
        headers = [h for h in table.columns if h in known and known[h].quantity in own]
        says_seldom = config.reads_touch or config.is_rest
        if says_seldom and headers and table[headers].isna().all(axis=None):
            table = table.drop(columns=headers)
            notes.append(f"{sensor} has no reading, left out")
    return table, tuple(notes)


def recording_from_table(
    table: pd.DataFrame, pen: PenConfig, name: str, *, units: Mapping[str, str] | None = None
) -> Recording:
    """Turn a table into a recording of the pen's sensors that it has columns of.

    Parameters
    ----------
    units : sensor name → unit of its columns, for headers without one

    Raises
    ------
    InputError
        If a column is missing, unknown, given twice or empty, a cell is not a
        finite number, or times do not increase; the message names column and row.
    """
    where = f"recording {name}"
    columns = recording_columns(pen, units or {})
    headers = plain_headers([str(header) for header in table.columns], columns, where)
    table = table.set_axis(headers, axis=1)
    found: dict[str, str] = {}
    for header in headers:
        if header not in columns:
            raise InputError(
                f"{where}: unknown column {short(header)}, expected {expected_for(header, columns)}"
            )
        quantity = columns[header].quantity
        other = found.setdefault(quantity, header)
        if other != header:
            raise InputError(
                f"{where}: columns {other} and {header} both give {quantity}, expected one"
            )
    check_units_given(units or {}, pen, headers, where)
    if TIME not in found:
        raise InputError(
            f"{where}: expected exactly one column of {', '.join(spellings(TIME, columns))}, "
            "found none"
        )
    if not len(table):
        raise InputError(f"{where} is empty below its header, expected at least one sample")
    values = {
        quantity: numbers(table[header], where) * columns[header].factor
        for quantity, header in found.items()
    }
    time_s = increasing_times(values[TIME], found[TIME], where)
    readings, arrivals = {}, {}
    for sensor, config in pen.sensors.items():
        if (arrival := f"{sensor}_{ARRIVAL}") in found:
            arrivals[sensor] = np.round(values[arrival], TIME_DIGITS)
        axes = [f"{sensor}_{axis}" for axis, _ in config.reading_axes]
        missing = [axis for axis in axes if axis not in found]
        if len(missing) == len(axes):
            continue
        if missing:
            raise InputError(
                f"{where}: column {', '.join(missing)} is missing, expected every axis of {sensor}"
            )
        readings[sensor] = np.column_stack([values[axis] for axis in axes])
        if np.isnan(readings[sensor]).all():
            raise InputError(
                f"{where}: the columns of {sensor} are empty, expected a reading or no such columns"
            )
    if not readings:
        raise InputError(f"{where}: no sensor's columns, expected {expected_for('', columns)}")
    states = [quantity for quantity in found if quantity.startswith(TRUTH_PREFIX)]
    truth = None
    if states:
        names = tuple(state.removeprefix(TRUTH_PREFIX) for state in states)
        truth = Truth(time_s, names, np.column_stack([values[state] for state in states]))
    return Recording(name, time_s, readings, truth, arrivals=arrivals)


def recording_to_table(recording: Recording, pen: PenConfig) -> pd.DataFrame:
    """Return a recording as a table with units in its headers, truth included."""
    columns: dict[str, Array] = {"time_s": recording.time_s}
    for sensor, values in recording.readings.items():
        for i, (axis, unit) in enumerate(pen.sensors[sensor].reading_axes):
            columns[f"{sensor}_{axis}_{unit}"] = values[:, i]
    columns |= {f"{sensor}_{ARRIVAL}_s": at for sensor, at in recording.arrivals.items()}
    if recording.truth is not None:
        # The truth may be given at more instants than the readings.
        states = recording.truth.states(recording.truth.names, recording.time_s)
        for i, state in enumerate(recording.truth.names):
            columns[TRUTH_PREFIX + state] = states[:, i]
    return pd.DataFrame(columns)
