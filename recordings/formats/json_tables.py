"""JSON as tables: an object a line, a list of objects, or an object of lists.

``{"t": 12, "accel": {"x": 0.1, …}, "gyro": [0.1, 0.2, 0.3]}`` becomes the columns ``t``,
``accel.x``, …, ``gyro[0]``, ….
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pandas as pd

from models.errors import InputError
from models.limits import check_most
from models.parsed import json_data
from recordings.foreign.source_table import SourceTable
from recordings.foreign.spelt_numbers import respelt
from recordings.foreign.told import counted
from recordings.formats.unpacked import open_text

JSON_SUFFIXES = (".json", ".jsonl", ".ndjson")
EXPECTED = "JSON with an object for each sample"
MOST_CHATTER = 0.2
"""Part of the lines that may be no objects."""
_Row = dict[str, Any]


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
    if not rows:
        rows = _samples(json_data(data, where, expected=EXPECTED))
    if not rows:
        raise InputError(f"{where}: holds no samples, expected {EXPECTED}")
    check_most("rows", len(rows), where)
    flat = [dict(_flat(row)) for row in rows]
    names = dict.fromkeys(name for row in flat for name in row)
    check_most("columns", len(names), where)
    for name in names:
        check_most("cell_bytes", len(name), f"{where}: a key")
    check_most("values", len(names) * len(rows), where)
    frame = respelt(pd.DataFrame(flat, columns=list(names)), ".")
    repairs = (f"{counted(left_out, 'line')} left out, no object",) if left_out else ()
    return [SourceTable(path.name, frame.infer_objects(), repairs=repairs)]


def is_json(line: str) -> bool:
    """Whether a line begins as an object with a key does."""
    return line.lstrip().startswith('{"')


def _of_lines(data: bytes, where: str) -> tuple[list[_Row], int]:
    """Return the objects of lines, and how many others there are; nothing where it is one text."""
    lines = [line for line in data.splitlines() if line.strip()]
    with suppress(InputError):  # at once: a line of its own costs ten times as much
        whole = json_data(b"[" + b",".join(lines) + b"]", where)
        if len(whole) == len(lines) > 1 and all(isinstance(row, dict) for row in whole):
            return whole, 0
    rows: list[_Row] = []
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


def _samples(data: Any) -> list[_Row]:
    """Return the objects of the longest list in a text, or those that lists of numbers make."""
    if isinstance(data, list):
        rows = [row for row in data if isinstance(row, dict)]
        return rows if len(rows) > 0.5 * len(data) else []
    if not isinstance(data, dict):
        return []
    found = [_samples(value) for value in data.values()]
    if (longest := max(found, key=len, default=[])) and len(longest) > 1:
        return longest
    lists = {key: value for key, value in data.items() if isinstance(value, list)}
    n = max(map(len, lists.values()), default=0)
    columns = {key: value for key, value in lists.items() if len(value) == n > 1}
    return [dict(zip(columns, cells, strict=True)) for cells in zip(*columns.values(), strict=True)]


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
