"""Which parts of a JSON text are samples, by the shapes that programs write.

A list of objects, a sample each, or a packet of several: ``{"Timestamp": 12, "ArrayAcc": [{"x":
0.1, …}, …]}`` (Movesense, meas/imu.yaml). An object of lists, a column each, or of lists of
objects, a sensor each, or of both, a sample at each place. A list of names beside one of rows: Edge
Impulse's ``sensors``, ``values`` and ``interval_ms`` (docs.edgeimpulse.com, Data acquisition
format), and what pandas calls "split".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from models.errors import InputError
from models.limits import check_most
from models.parsed import json_data
from recordings.foreign.column_names import kind_named, meaning

Row = dict[str, Any]
_MOST_BESIDE = 40
"""Numbers beside samples that are kept."""
_LOOKED_AT = 20
"""Rows at whose shape one looks."""


@dataclass(frozen=True)
class Samples:
    """Objects of a text that are samples.

    Parameters
    ----------
    name : the key that they stand at; empty for the text itself
    rows : key → number, text, or a vector or object of numbers
    beside : numbers that stand beside them, a line each: ``interval_ms: 10``
    has_names : whether the keys are the text's own
    """

    name: str
    rows: list[Row]
    beside: str = ""
    has_names: bool = True


def samples_of(data: Any, where: str) -> list[Samples]:
    """Return the samples in a text, those of a sensor apart from others where they stand so.

    Raises
    ------
    InputError
        If `unpacked` refuses them.
    """
    if found := list(_objects(data, "", "", where)):
        return found
    if isinstance(data, dict):
        rows = _by_place(_columns(data))
        return [Samples("", rows, _beside(data))] if rows else []
    if not _width(data):
        return []
    rows = [{str(k): cell for k, cell in enumerate(row, 1)} for row in data]
    return [Samples("", rows, has_names=False)]


def _objects(data: Any, name: str, beside: str, where: str) -> Iterator[Samples]:
    """Yield lists of objects, and of rows beside their names, wherever they stand."""
    if isinstance(data, list):
        rows = [row for row in data if isinstance(row, dict)]
        if len(rows) > max(1, 0.5 * len(data)):
            yield Samples(name, unpacked(rows, where), beside)
    elif isinstance(data, dict):
        beside = f"{beside}\n{_beside(data)}"
        if rows := _named_rows(data) or _zipped(data):
            yield Samples(name, rows, beside)
        else:
            for key, value in data.items():
                yield from _objects(value, key, beside, where)


def _beside(data: Mapping[str, Any]) -> str:
    """Return the numbers that stand in an object, a line each."""
    numbers = [(key, value) for key, value in data.items() if isinstance(value, int | float)]
    return "\n".join(f"{key}: {value}" for key, value in numbers[:_MOST_BESIDE])


def unpacked(rows: list[Row], where: str) -> list[Row]:
    """Return a row for each sample of packets; each has what its packet says once, as its stamp.

    Lists beside readings, as of touches or satellites, are no packets.

    Raises
    ------
    InputError
        If they are more values than `models.limits.LIMITS` allows.
    """
    if not any(_holds_more(row) for row in rows[:_LOOKED_AT]):
        return rows
    rows = [dict(_texts_read(row)) for row in rows]
    packed = {key for row in rows[:_LOOKED_AT] for key, one in _cells(row) if _is_packet(key, one)}
    beside = {key for row in rows[:_LOOKED_AT] for key, _ in _cells(row)} - packed
    if not packed or sum(meaning(key) is not None for key in beside) >= len("xyz"):
        return rows
    found: list[Row] = []
    values = 0
    for row in rows:
        cells = dict(_cells(row))
        lists = {key: cells.pop(key) for key in packed & cells.keys()}
        lists = {key: value for key, value in lists.items() if isinstance(value, list)}
        n = max(map(len, lists.values()), default=1)
        values += n * (len(cells) + len(lists))
        check_most("values", values, where)
        found += [
            cells | {key: value[k] for key, value in lists.items() if k < len(value)}
            for k in range(n)
        ]
    return found


def _holds_more(row: Row) -> bool:
    return any(
        _is_packet(key, value) or (isinstance(value, str) and value.startswith("{"))
        for key, value in _cells(row)
    )


def _texts_read(row: Row) -> Iterator[tuple[str, Any]]:
    """Yield the cells of an object, of which a text may be one, as a broker's log has them."""
    for key, value in row.items():
        if isinstance(value, str) and value.startswith("{"):
            with suppress(InputError):
                value = json_data(value.encode(), key)
        yield key, value


def _cells(row: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield what stands in an object; a key within a key is joined by a point."""
    for key, value in row.items():
        if isinstance(value, dict):
            yield from ((f"{key}.{name}", one) for name, one in _cells(value))
        else:
            yield key, value


def _is_packet(key: str, value: Any) -> bool:
    """Whether a list is one of samples: of objects, or of vectors of a sensor."""
    if not isinstance(value, list) or not value:
        return False
    if all(isinstance(one, dict) for one in value):
        return True
    return _width(value) == len("xyz") and kind_named(key) is not None


def _width(rows: Any) -> int:
    """Return the length of all lists that are a list's; 0 where it is none of such."""
    if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
        return 0
    widths = {len(row) for row in rows}
    return widths.pop() if len(widths) == 1 else 0


def _named_rows(data: Mapping[str, Any]) -> list[Row]:
    """Return rows of a list of lists beside a list of as many names, or of objects with a name."""
    for rows in data.values():
        if (width := _width(rows)) > 1:
            for names in map(_names, data.values()):
                if len(names) == width == len(set(names)):
                    return [dict(zip(names, row, strict=True)) for row in rows]
    return []


def _zipped(data: Mapping[str, Any]) -> list[Row]:
    """Return a row for each place of lists of one length, some of objects, some of numbers."""
    lists = {key: value for key, value in data.items() if isinstance(value, list)}
    rows = _by_place(lists)
    kinds = {isinstance(cell, dict) for cell in rows[0].values()} if rows else set()
    return rows if len(kinds) == 2 else []


def _by_place(lists: Mapping[str, list[Any]]) -> list[Row]:
    """Return a row for each place in the longest lists, where these are longer than one."""
    n = max(map(len, lists.values()), default=0)
    longest = {key: value for key, value in lists.items() if len(value) == n > 1}
    return [dict(zip(longest, cells, strict=True)) for cells in zip(*longest.values(), strict=True)]


def _names(value: Any) -> list[str]:
    found: list[str] = []
    for one in value if isinstance(value, list) else []:
        if isinstance(one, str):
            found.append(one)
        elif isinstance(one, dict) and isinstance(one.get("name"), str):
            unit = one.get("units", one.get("unit"))
            found.append(f"{one['name']} [{unit}]" if isinstance(unit, str) else one["name"])
    return found


def _columns(data: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Return the lists in an object that are no lists of objects."""
    return {
        key: value
        for key, value in _cells(data)
        if isinstance(value, list) and not any(isinstance(one, dict) for one in value)
    }
