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

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd

from estimation.output_file import check_file, whole_file
from estimation.recording import Recording
from models.arrays import Array
from models.border import reading
from models.errors import InputError
from models.pen_config import PenConfig
from models.units import with_unit
from recordings.formats.arrow import own_columns, read_arrow
from recordings.formats.columns import (
    ARRIVAL,
    TRUTH_PREFIX,
)
from recordings.formats.csv_files import check_header, read_csv
from recordings.formats.table_header import TableHeader
from recordings.formats.table_writer import TableWriter
from recordings.recording_check import RecordingCheck
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
    table = table.select(own_columns(table.column_names))
    check_header(table.column_names, where)
    return table.to_pandas(split_blocks=True)  # a column is as it was read, not copied to others


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
    with whole_file(path) as file, TableWriter(file, path.suffix) as writer:
        writer.write(table)


def load_table(
    path: Path, pen: PenConfig, *, units: Mapping[str, str] | None = None
) -> WrittenRecording:
    """Read a recording from a table whose units make sense; see `recording_from_table`."""
    table = read_table(path)
    header = TableHeader.of(list(table.columns), pen, str(path), units=units)
    header, notes = header.without_silent(pen, [table])
    recording = _whole(header, table)
    check = RecordingCheck(header, pen)
    check.take(recording)
    check.end()
    return WrittenRecording(recording, notes=notes)


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
    return _whole(TableHeader.of(list(table.columns), pen, name, units=units), table)


def _whole(header: TableHeader, table: pd.DataFrame) -> Recording:
    if not len(table):
        raise InputError(f"{header.where} is empty below its header, expected at least one sample")
    recording = header.recording(table)
    for sensor, readings in recording.readings.items():
        if np.isnan(readings).all():
            raise header.empty(sensor)
    return recording


def recording_to_table(recording: Recording, pen: PenConfig) -> pd.DataFrame:
    """Return a recording as a table with units in its headers, truth included."""
    columns: dict[str, Array] = {"time_s": recording.time_s}
    for sensor, values in recording.readings.items():
        for i, (axis, unit) in enumerate(pen.sensors[sensor].reading_axes):
            columns[with_unit(f"{sensor}_{axis}", unit)] = values[:, i]
    columns |= {f"{sensor}_{ARRIVAL}_s": at for sensor, at in recording.arrivals.items()}
    if recording.truth is not None:
        # The truth may be given at more instants than the readings.
        states = recording.truth.states(recording.truth.names, recording.time_s)
        for i, state in enumerate(recording.truth.names):
            columns[TRUTH_PREFIX + state] = states[:, i]
    return pd.DataFrame(columns)
