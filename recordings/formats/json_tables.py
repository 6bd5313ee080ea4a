"""JSON as tables: an object a line, a list of objects, or an object of lists.

``{"t": 12, "accel": {"x": 0.1, …}, "gyro": [0.1, 0.2, 0.3]}`` becomes the columns ``t``,
``accel.x``, …, ``gyro[0]``, ….
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pandas as pd

from models.errors import InputError
from models.limits import check_most
from models.parsed import json_data
from models.shown_text import short
from recordings.foreign.source_table import SourceTable
from recordings.foreign.spelt_numbers import respelt
from recordings.foreign.told import counted
from recordings.formats.json_shapes import Row, Samples, samples_of, unpacked
from recordings.formats.unpacked import open_text

JSON_SUFFIXES = (".json", ".jsonl", ".ndjson")
EXPECTED = "JSON with an object for each sample"
MOST_CHATTER = 0.2
"""Part of the lines that may be no objects."""


def read_json_table(
    path: Path, where: str, *, header: Sequence[str] | None = None
) -> list[SourceTable]:
    """Read JSON as a table.

    Raises
    ------
    InputError
        If it holds no samples, or is larger or deeper than `models.limits.LIMITS` allows.
    """
    file, _ = open_text(path, where, EXPECTED)
    with file:
        data = file.read()
    check_most("json_bytes", len(data), where)
    rows, left_out = _of_lines(data, where)
    found = [Samples("", unpacked(rows, where))] if rows else []
    if not found:
        found = samples_of(json_data(_plain(data), where, expected=EXPECTED), where)
    if not found:
        raise InputError(f"{where}: holds no samples, expected {EXPECTED}")
    check_most("rows", sum(len(one.rows) for one in found), where)
    repairs = (f"{counted(left_out, 'line')} left out, no object",) if left_out else ()
    return [
        SourceTable(
            path.name if len(found) == 1 else f"{path.name} ({short(one.name)})",
            _frame(one.rows, where, names=None if one.has_names else header),
            one.beside.strip(),
            repairs=repairs,
            has_header=one.has_names,
        )
        for one in found
    ]


def _frame(rows: list[Row], where: str, *, names: Sequence[str] | None) -> pd.DataFrame:
    """Return a table with a column for each key, or with names that somebody says."""
    flat = [dict(_flat(row)) for row in rows]
    keys = dict.fromkeys(name for row in flat for name in row)
    check_most("columns", len(keys), where)
    for key in keys:
        check_most("cell_bytes", len(key), f"{where}: a key")
    check_most("values", len(keys) * len(rows), where)
    frame = respelt(pd.DataFrame(flat, columns=list(keys)), ".").infer_objects()
    return frame if names is None else frame.rename(columns=dict(zip(keys, names, strict=False)))


def is_json(line: str) -> bool:
    """Whether a line begins as an object with a key does, in JSON or as Python prints it."""
    return line.lstrip().startswith(('{"', "{'"))


def _plain(data: bytes) -> bytes:
    """Return what Python prints of a dictionary, or a list of them, as JSON."""
    if not data.lstrip().startswith((b"{'", b"[{'")):
        return data
    return re.sub(rb"\bNone\b|\bnan\b", b"null", data.replace(b"'", b'"'))


def _of_lines(data: bytes, where: str) -> tuple[list[Row], int]:
    """Return the objects of lines, and how many others there are; nothing where it is one text."""
    lines = [_plain(line) for line in data.splitlines() if line.strip()]
    with suppress(InputError):  # at once: a line of its own costs ten times as much
        whole = json_data(b"[" + b",".join(lines) + b"]", where)
        if len(whole) == len(lines) > 1 and all(isinstance(row, dict) for row in whole):
            return whole, 0
    rows: list[Row] = []
    for number, line in enumerate(lines):
        try:
            row = json_data(line, where)
        except InputError:
            row = None
        if isinstance(row, dict):
            rows.append(row)
        if number - len(rows) > 10 + MOST_CHATTER * number:
            return [], 0
    is_one = len(rows) < 2 or len(lines) - len(rows) > MOST_CHATTER * len(lines) + 1
    return ([], 0) if is_one else (rows, len(lines) - len(rows))


def _flat(row: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the numbers and texts of an object: a key within a key is joined by a point."""
    for key, value in row.items():
        if isinstance(value, dict):
            yield from ((f"{key}.{name}", one) for name, one in _flat(value))
        elif isinstance(value, list):
            cells = {f"{key}[{k}]": one for k, one in enumerate(value[:4])}
            yield from ((k, one) for k, one in cells.items() if not isinstance(one, dict | list))
        elif value is None or isinstance(value, str | int | float):
            yield key, value
