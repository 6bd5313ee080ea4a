"""Tables with a row for each reading of any sensor, as Android's loggers write them.

A column names the sensor, by a word or by the number of Android's ``Sensor.TYPE_…``; three others
are its reading.
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
    meaning,
)
from recordings.foreign.header_units import spelt_words, words_of
from recordings.foreign.source_table import SourceTable
from recordings.foreign.stamps import stamp_headers

ANDROID_TYPES: Mapping[int, str] = MappingProxyType(
    {1: ACCELEROMETER, 2: MAGNETOMETER, 4: GYROSCOPE, 9: GRAVITY, 10: LINEAR}
)
"""Number of a sensor in Android's documentation of ``Sensor`` → its kind."""
MOST_SENSORS = 40
_NAMES = spelt_words("sensor type name sensortype sensorname device message topic kind")
_VALUE = re.compile(r"(?:v|val|value|values|data)\D*([0-3])\D*$", re.IGNORECASE)


def unstacked(table: SourceTable) -> list[SourceTable]:
    """Return a table for each sensor of one that names them row by row; itself for any other."""
    for header in map(str, table.frame.columns):
        kinds = _kinds(table.frame[header], header)
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
    return [table]


def _kinds(cells: pd.Series, header: str) -> dict[object, str]:
    """Return name in a column → kind of the sensors that it names; nothing for any other column."""
    if cells.dtype.kind == "f" or len(cells) < 2:
        return {}
    is_number = cells.dtype.kind in "iu"
    if is_number and not _NAMES & set(words_of(header)):
        return {}
    names = list(cells.head(1000).dropna().unique())
    if len(names) > MOST_SENSORS:
        return {}
    names = list(cells.dropna().unique())
    if len(names) > MOST_SENSORS:
        return {}
    if is_number:
        return {name: ANDROID_TYPES[int(name)] for name in names if int(name) in ANDROID_TYPES}
    found = {name: kind_named(str(name)) for name in names if len(str(name)) > 2}
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


def _part(
    frame: pd.DataFrame, sensor: str, name: object, values: list[str], kind: str
) -> pd.DataFrame:
    part = frame[frame[sensor] == name].drop(columns=sensor).reset_index(drop=True)
    return _renamed(part, dict(zip(values, (f"{kind} {axis}" for axis in "xyz"), strict=True)))


def _renamed(frame: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    """Return a table with columns renamed; others of the new names are left out."""
    others = [name for name in names.values() if name in frame and name not in names]
    return frame.drop(columns=others).rename(columns=names)
