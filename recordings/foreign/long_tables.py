"""Tables with a row for each reading of any sensor, as Android's loggers write them.

A column names the sensor, by a word or by the number of Android's ``Sensor.TYPE_…``; three others
are its reading. Or it names one of several devices, whose rows stand between each other's.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import pandas as pd

from models.shown_text import short
from recordings.foreign.column_names import (
    ACCELEROMETER,
    GRAVITY,
    GYROSCOPE,
    LINEAR,
    MAGNETOMETER,
    kind_named,
    kind_of_words,
    meaning,
)
from recordings.foreign.header_units import spelt_words, words_of
from recordings.foreign.number_rows import unpivoted
from recordings.foreign.source_table import SourceTable
from recordings.foreign.stamps import stamp_headers

ANDROID_TYPES: Mapping[int, str] = MappingProxyType(
    {1: ACCELEROMETER, 2: MAGNETOMETER, 4: GYROSCOPE, 9: GRAVITY, 10: LINEAR}
)
"""Number of a sensor in Android's documentation of ``Sensor`` → its kind."""
MOST_SENSORS = 40
LEAST_ROWS = 20
"""Rows that a device has at least."""
_DEVICE_WORDS = spelt_words("sensor device imu node id address addr mac name serial")
_NAMES = spelt_words("sensor type name sensortype sensorname device message topic kind")
_VALUE = re.compile(r"(?:v|val|value|values|data)\D*([0-3])\D*$", re.IGNORECASE)


def unstacked(table: SourceTable) -> list[SourceTable]:
    """Return a table for each sensor of one that names them row by row; itself for any other.

    Raises
    ------
    InputError
        If `unpivoted` refuses it.
    """
    of_numbers = unpivoted(table)
    if of_numbers is not None:
        return of_numbers
    headers = list(map(str, table.frame.columns))
    names_readings = sum(meaning(header) is not None for header in headers) >= len("xyz")
    for header in headers:
        kinds = _kinds(table.frame[header], header, names_readings=names_readings)
        timed = _with_times(table, header) if kinds and not table.has_header else table
        values = _value_headers(timed, header) if kinds else []
        if len(values) >= 3:
            return [
                replace(
                    timed,
                    name=f"{table.name} ({short(name)})",
                    frame=_part(timed.frame, header, name, values, kind),
                    said=(*table.said, f"rows of {short(name)} are a sensor of its own"),
                )
                for name, kind in kinds.items()
            ]
    return _by_device(table)


def _by_device(table: SourceTable) -> list[SourceTable]:
    """Return a table for each device of one whose rows are of several, by its number or name."""
    headers = [str(header) for header in table.frame.columns]
    if sum(meaning(header) is not None for header in headers) >= len("xyz"):
        for header in headers:
            cells = table.frame[header]
            words = set(words_of(header))
            if words and words <= _DEVICE_WORDS and cells.dtype.kind != "f":
                rows = cells.value_counts(sort=False)
                if 1 < len(rows) <= MOST_SENSORS and rows.min() >= LEAST_ROWS:
                    return [
                        replace(
                            table,
                            name=f"{table.name} ({short(header)} {short(str(name))})",
                            frame=_of(table.frame, header, name),
                            said=(*table.said, f"rows of {short(str(name))} are a device's own"),
                        )
                        for name in rows.index
                    ]
    return [table]


def _kinds(cells: pd.Series, header: str, *, names_readings: bool) -> dict[object, str]:
    """Return name in a column → kind of the sensors that it names; nothing for any other column.

    Parameters
    ----------
    names_readings : whether other columns say by themselves what they read; then a number is none
        of Android's
    """
    if cells.dtype.kind == "f" or len(cells) < 2:
        return {}
    is_number = cells.dtype.kind in "iu"
    if is_number and (not _NAMES & set(words_of(header)) or names_readings):
        return {}
    names = list(cells.head(1000).dropna().unique())
    if len(names) > MOST_SENSORS:
        return {}
    names = list(cells.dropna().unique())
    if len(names) > MOST_SENSORS:
        return {}
    if is_number:
        return {name: ANDROID_TYPES[int(name)] for name in names if int(name) in ANDROID_TYPES}
    is_lettered = {"a", "g"} <= {str(name).casefold() for name in names}
    told = kind_of_words if is_lettered else kind_named
    found = {name: told(str(name)) for name in names if is_lettered or len(str(name)) > 2}
    return {name: kind for name, kind in found.items() if kind is not None}


def _value_headers(table: SourceTable, sensor: str) -> list[str]:
    """Return the columns of x, y, z: by these names, by a number, else those after all stamps."""
    headers = [str(header) for header in table.frame.columns if header != sensor]
    for named in (
        [h for h in headers if words_of(h)[-1:] in (["x"], ["y"], ["z"])],
        [h for h in headers if _VALUE.search(h)],
    ):
        if len(named) >= 3:
            return named[:3]
    by_meaning = [header for header in headers if meaning(header) is not None]
    if len(by_meaning) >= 3:
        return by_meaning[:3]
    stamps = stamp_headers(headers)
    return [
        header
        for header in headers
        if header not in stamps and pd.api.types.is_numeric_dtype(table.frame[header])
    ][:3]


def _with_times(table: SourceTable, sensor: str) -> SourceTable:
    """Return a table without a header whose first column of numbers is that of times."""
    numbers = [
        name
        for name in table.frame.columns
        if name != sensor and pd.api.types.is_numeric_dtype(table.frame[name])
    ]
    return replace(table, frame=_renamed(table.frame, dict.fromkeys(numbers[:1], "time")))


def _of(frame: pd.DataFrame, header: str, name: object) -> pd.DataFrame:
    """Return the rows with a name in a column, without it."""
    return frame[frame[header] == name].drop(columns=header).reset_index(drop=True)


def _part(
    frame: pd.DataFrame, sensor: str, name: object, values: list[str], kind: str
) -> pd.DataFrame:
    part = _of(frame, sensor, name)
    return _renamed(part, dict(zip(values, (f"{kind} {axis}" for axis in "xyz"), strict=True)))


def _renamed(frame: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    """Return a table with columns renamed; others of the new names are left out."""
    others = [name for name in names.values() if name in frame and name not in names]
    return frame.drop(columns=others).rename(columns=names)
