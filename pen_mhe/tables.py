"""Recordings and estimates as tables: CSV and Parquet.

A recording has a column ``time_s`` (or ``time_ms``, ``time_us``) and columns
``<sensor>_<axis>``, with the unit at the end of the header
(``accel_x_m_s2``, ``gyro_x_deg_s``) or given by option, else SI. An empty cell
is a sensor without a reading. Columns ``true_<state>`` hold the truth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd

from estimation.recording import Recording, Truth
from models.arrays import Array
from models.errors import InputError
from models.measurement import reading_axes
from models.pen import PenConfig
from models.units import UNITS

TIME_COLUMNS = MappingProxyType({f"time_{unit}": factor for unit, factor in UNITS["s"].items()})
TRUTH_PREFIX = "true_"
TABLE_SUFFIXES = (".csv", ".parquet")


def read_table(path: Path) -> pd.DataFrame:
    """Read a CSV or Parquet file by its suffix."""
    readers: Mapping[str, Callable[[Path], pd.DataFrame]] = {
        ".csv": pd.read_csv,
        ".parquet": pd.read_parquet,
    }
    if path.suffix not in readers:
        raise InputError(
            f"recording {path}: suffix {path.suffix or '(none)'} is unknown, "
            "expected .csv, .parquet or a D-POINT folder"
        )
    try:
        return readers[path.suffix](path)
    except OSError as error:
        raise InputError(f"recording {path}: {error.strerror or error}, expected a table") from None
    except (ValueError, pd.errors.ParserError) as error:
        raise InputError(f"recording {path}: {error}, expected a {path.suffix[1:]} table") from None


def prepare_output(path: Path, suffixes: Sequence[str] = TABLE_SUFFIXES) -> None:
    """Refuse a suffix before the work that would be lost, and make folder and file.

    Raises
    ------
    InputError
        If the suffix is not one of `suffixes`, or the folder cannot be made.
    """
    if path.suffix not in suffixes:
        raise InputError(
            f"output {path}: suffix {path.suffix or '(none)'} is unknown, "
            f"expected {', '.join(suffixes)}"
        )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("ab"):
            pass
    except OSError as error:
        raise InputError(
            f"output {path}: {error.strerror}, expected a file that can be written"
        ) from None


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV or Parquet by its suffix."""
    prepare_output(path)
    if path.suffix == ".csv":
        table.to_csv(path, index=False)
    else:
        table.to_parquet(path, index=False)


def recording_from_table(
    table: pd.DataFrame, pen: PenConfig, name: str, units: Mapping[str, str] | None = None
) -> Recording:
    """Turn a table into a recording of the pen's sensors that it has columns of.

    Parameters
    ----------
    units : sensor name → unit of its columns, for headers without one

    Raises
    ------
    InputError
        If a column is missing or unknown, or a cell is not a number; the
        message names column and row.
    """
    time_s = _time(table, name)
    for sensor in units or {}:
        if not _plain_columns(sensor, pen) & {str(column) for column in table.columns}:
            raise InputError(
                f"recording {name}: a unit is given for {sensor}, expected columns of it "
                "without a unit in their header"
            )
    readings, used = {}, set(TIME_COLUMNS)
    for sensor, config in pen.sensors.items():
        axes = reading_axes(config)
        columns = [_column(table, sensor, axis, unit, units or {}) for axis, unit in axes]
        present = [column for column, _ in columns if column is not None]
        if not present:
            continue
        if len(present) < len(axes):
            missing = ", ".join(
                f"{sensor}_{axis}"
                for (axis, _), (found, _) in zip(axes, columns, strict=True)
                if found is None
            )
            raise InputError(f"recording {name}: column {missing} is missing, expected it")
        used.update(present)
        readings[sensor] = np.column_stack(
            [_numbers(table, str(column), name) * factor for column, factor in columns]
        )
    truth_columns = [str(c) for c in table.columns if str(c).startswith(TRUTH_PREFIX)]
    unknown = [str(c) for c in table.columns if c not in used and c not in truth_columns]
    if unknown or not readings:
        expected = ", ".join(
            f"{sensor}_{axis}_{unit}"
            for sensor, config in pen.sensors.items()
            for axis, unit in reading_axes(config)
        )
        what = f"unknown column {unknown[0]}" if unknown else "no sensor's columns"
        raise InputError(f"recording {name}: {what}, expected time_s, {expected}")
    return Recording(
        name, time_s, MappingProxyType(readings), _truth(table, time_s, truth_columns, name)
    )


def recording_to_table(recording: Recording, pen: PenConfig) -> pd.DataFrame:
    """Return a recording as a table with units in its headers, truth included."""
    columns: dict[str, Array] = {"time_s": recording.time_s}
    for sensor, values in recording.readings.items():
        for i, (axis, unit) in enumerate(reading_axes(pen.sensors[sensor])):
            columns[f"{sensor}_{axis}_{unit}"] = values[:, i]
    if recording.truth is not None:
        for i, state in enumerate(recording.truth.names):
            columns[TRUTH_PREFIX + state] = recording.truth.values[:, i]
    return pd.DataFrame(columns)


def _plain_columns(sensor: str, pen: PenConfig) -> set[str]:
    if sensor not in pen.sensors:
        return set()
    return {f"{sensor}_{axis}" for axis, _ in reading_axes(pen.sensors[sensor])}


def _time(table: pd.DataFrame, name: str) -> Array:
    found = [column for column in TIME_COLUMNS if column in table.columns]
    if len(found) != 1:
        raise InputError(
            f"recording {name}: expected exactly one column of {', '.join(TIME_COLUMNS)}, "
            f"found {', '.join(found) or 'none'}"
        )
    time_s = _numbers(table, found[0], name) * TIME_COLUMNS[found[0]]
    if np.isnan(time_s).any():
        row = int(np.flatnonzero(np.isnan(time_s))[0])
        raise InputError(f"recording {name}: column {found[0]} is empty in row {row}")
    return np.round(time_s, 9)


def _column(
    table: pd.DataFrame, sensor: str, axis: str, si_unit: str, units: Mapping[str, str]
) -> tuple[str | None, float]:
    """Return the column that holds an axis and its factor to SI, (None, 1) if none does."""
    accepted = UNITS[si_unit]
    for unit, factor in accepted.items():
        if f"{sensor}_{axis}_{unit}" in table.columns:
            return f"{sensor}_{axis}_{unit}", factor
    plain = f"{sensor}_{axis}"
    if plain not in table.columns:
        return None, 1.0
    unit = units.get(sensor, si_unit)
    if unit not in accepted:
        raise InputError(f"unit {unit} of {sensor} is unknown, expected {' or '.join(accepted)}")
    return plain, accepted[unit]


def _numbers(table: pd.DataFrame, column: str, name: str) -> Array:
    numbers = pd.to_numeric(table[column], errors="coerce").to_numpy(dtype=float)
    bad = np.isnan(numbers) & table[column].notna().to_numpy()
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise InputError(
            f"recording {name}: column {column}, row {row}: "
            f"{table[column].iloc[row]!r} is not a number"
        )
    return numbers


def _truth(table: pd.DataFrame, time_s: Array, columns: list[str], name: str) -> Truth | None:
    if not columns:
        return None
    values = np.column_stack([_numbers(table, column, name) for column in columns])
    return Truth(time_s, tuple(c.removeprefix(TRUTH_PREFIX) for c in columns), values)
