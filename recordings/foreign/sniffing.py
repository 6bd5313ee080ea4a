"""How a text writes a table: what separates cells and decimals, where its rows begin.

A row of data is a line of numbers. What separates its cells is what makes most of them numbers;
the header is the last line of words above the first row, with as many cells.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from recordings.foreign.header_units import spelt_words, unit_of
from recordings.foreign.spelt_numbers import COMMA, POINT

DELIMITERS = ("\t", ";", "|", ",", " ")
"""What may separate cells; a blank is any number of blanks and tabs."""
MISSING = spelt_words(
    "nan na n/a n.a. n.d. null none - -- --- nil #n/a nat #na missing undefined ?"
) | {""}
"""Cells that say that there is no reading, in small letters."""
_STAMP = re.compile(
    r"(?:\d{1,4}[-/.:]\d{1,2}[-/.:]\d{1,4}(?:[T ][\w.:/ +-]*)?|\d{1,2}:\d{2}[\w.:/ +-]*)"
    r"(?:,\d{1,9})?[\d:Zz+-]*(?: ?[AaPp][Mm])?"
)
_LONGEST_NUMBER = 100
_RULE = re.compile(r"[-=_+|:*~ ]*")
"""A cell of a line that is drawn between header and rows."""
_COMMENT = re.compile(r"^\s*(?:#+|%+|//+|;+)\s*")
_LEAST_NUMBERS = 0.5
"""Part of a line's cells that are numbers where it is a row of data."""
_HEADER_ROWS = 3
_LEAST_COLUMNS, _AS_GOOD = 4, 0.9
"""Columns by tabs, and how good they are against those by blanks, where blanks part no cells."""
_MOST_ABOVE, _IN_A_ROW = 10, 5
"""Lines of numbers above the header (of markers, of sensors), and how many rows follow each other
where they are none.
"""
_AXES = spelt_words("x y z w rx ry rz tx ty tz")


@dataclass(frozen=True)
class Dialect:
    """How a text writes a table.

    Parameters
    ----------
    delimiter : one of `DELIMITERS`
    decimal : point or comma
    header : the columns' names; None where no line above the first row names them
    first_line : lines before the first row of data
    columns : cells of a row
    preamble : the lines above the header
    """

    delimiter: str
    decimal: str
    header: tuple[str, ...] | None
    first_line: int
    columns: int
    preamble: str


def sniffed(lines: Sequence[str]) -> Dialect | None:
    """Return how lines, the first of a file, write a table; None where no line is a row of data."""
    found = [
        (quality, -rank, delimiter)
        for rank, delimiter in enumerate(DELIMITERS)
        if (quality := _quality(lines, delimiter)) is not None
    ]
    if not found:
        return None
    _, _, delimiter = max(one for one in found if not _is_within_cells(one, found))
    rows = [split_cells(line, delimiter) for line in lines]
    data = [i for i, cells in enumerate(rows) if _is_data(cells)]
    columns = Counter(len(rows[i]) for i in data).most_common(1)[0][0]
    whole = [i for i in data if len(rows[i]) == columns]
    damaged = set(data) - set(whole)  # these part no row from the next
    first = _first_row(whole, [i for i, line in enumerate(lines) if line.strip()], damaged)
    cells = [cell for i in data for cell in rows[i]]
    commas = sum(COMMA.fullmatch(cell) is not None for cell in cells)
    points = sum(POINT.fullmatch(cell) is not None and "." in cell for cell in cells)
    trailing = all(not rows[i][-1] for i in data if len(rows[i]) == columns)
    names, start = _header(rows, first, columns, trailing=trailing)
    return Dialect(
        delimiter, "," if commas > points else ".", names, first, columns, "\n".join(lines[:start])
    )


_Found = tuple[tuple[float, float, int], int, str]


def _is_within_cells(one: _Found, found: Sequence[_Found]) -> bool:
    """Whether blanks are within cells, of a date: tabs make about as many cells numbers."""
    return one[2] == " " and any(
        delimiter == "\t" and columns >= _LEAST_COLUMNS and alike >= _AS_GOOD * one[0][0]
        for (alike, _, columns), _, delimiter in found
    )


def _first_row(data: Sequence[int], told: Sequence[int], damaged: Collection[int]) -> int:
    """Return the first row of data: one that others follow, and no number above a header.

    Parameters
    ----------
    data : lines that are rows, in order
    told : lines that say anything
    damaged : rows that have more or fewer cells
    """
    place = {i: k for k, i in enumerate(i for i in told if i not in damaged)}
    for k, i in enumerate(data[:_MOST_ABOVE]):
        n = min(_IN_A_ROW, len(data) - k) - 1
        if place[data[k + n]] == place[i] + n:
            return i
    return data[0]


def split_cells(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without blanks and quotes around them."""
    if delimiter == " ":
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]
    except csv.Error:
        return [cell.strip() for cell in line.split(delimiter)]


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with a point or a comma, or a stamp of time."""
    return len(cell) <= _LONGEST_NUMBER and _spells_number(cell)


@lru_cache(maxsize=1 << 13)  # of each delimiter the cells of the same lines are asked again
def _spells_number(cell: str) -> bool:
    return any(form.fullmatch(cell) for form in (POINT, COMMA, _STAMP))


def _is_data(cells: Sequence[str]) -> bool:
    told = [cell for cell in cells if cell.casefold() not in MISSING]
    numbers = sum(is_number(cell) for cell in told)
    return len(cells) > 1 and numbers >= max(1, _LEAST_NUMBERS * len(told))


def _quality(lines: Sequence[str], delimiter: str) -> tuple[float, float, int] | None:
    """Return the part of lines that are rows of one length, and of cells that are numbers."""
    rows = [split_cells(line, delimiter) for line in lines if line.strip()]
    data = [cells for cells in rows if _is_data(cells)]
    if not data:
        return None
    columns, alike = Counter(map(len, data)).most_common(1)[0]
    cells = [cell for row in data for cell in row if cell.casefold() not in MISSING]
    numbers = sum(is_number(cell) for cell in cells)
    return round(alike / len(rows) * numbers / len(cells), 3), numbers / len(cells), columns


def _header(
    rows: Sequence[Sequence[str]], first: int, columns: int, *, trailing: bool
) -> tuple[tuple[str, ...] | None, int]:
    """Return the names above the first row of data, and the first line that gives them."""
    above: list[list[str]] = []
    i = first
    while i and len(above) < _HEADER_ROWS:
        cells = list(rows[i - 1])
        if all(_RULE.fullmatch(cell) for cell in cells):
            i -= 1
            if above:
                break
            continue
        cells[0] = _COMMENT.sub("", cells[0])
        if not cells[0] and len(cells) == columns + 1:  # ``# time ax``
            cells = cells[1:]
        if len(cells) == columns + 1 and cells[-1].casefold() == "comment":  # LabVIEW's, empty
            cells = cells[:-1]
        if len(cells) == columns - 1 and trailing:
            cells.append("")
        if len(cells) != columns or any(is_number(cell) for cell in cells if cell):
            break
        above.insert(0, cells)
        i -= 1
        if len(above) > 1 and not _explains(above[1]):
            above.pop(0)
            i += 1
            break
    if not above:
        return None, first
    names = [""] * columns
    for upper, lower in pairwise(above):
        for k in range(1, columns):
            if not upper[k] and lower[k].casefold() in _AXES:  # of a cell that spans several
                upper[k] = upper[k - 1]
    for cells in above:
        names = [_joined(name, cell) for name, cell in zip(names, cells, strict=True)]
    return tuple(names), i


def sniffed_header(rows: Sequence[Sequence[str]], first: int) -> tuple[str, ...] | None:
    """Return the names above the first row of data of a sheet; None where there are none."""
    return _header(rows, first, len(rows[first]), trailing=False)[0]


def _explains(cells: Sequence[str]) -> bool:
    """Whether a line stands below a header to explain it: units, axes; most of them known."""
    told = [cell.strip("[] ") for cell in cells if cell.strip("[]() -")]
    known = sum(unit_of(cell.strip("()")) is not None or cell.casefold() in _AXES for cell in told)
    return known > 0.5 * len(told)


def _joined(name: str, cell: str) -> str:
    cell = cell.strip()
    if not name or not cell:
        return name or cell
    if cell.casefold() in _AXES:
        return f"{name} {cell}"
    return f"{name} [{cell.strip('[]').removeprefix('(').removesuffix(')')}]"
