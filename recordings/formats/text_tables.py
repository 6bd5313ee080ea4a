"""Tables as texts: any delimiter, decimal point or comma, lines before the header, any encoding.

Lines that are no rows (what a sketch prints between them, a line that was cut off at the end) are
left out and counted.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from contextlib import ExitStack
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pandas as pd

from models.errors import InputError
from models.limits import check_most
from models.shown_text import value_text
from recordings.foreign.sniffing import MISSING, Dialect, sniffed, split_cells
from recordings.foreign.source_table import SourceTable
from recordings.foreign.spelt_numbers import respelt
from recordings.foreign.told import counted
from recordings.formats.cell_limits import check_cells
from recordings.formats.columns import loose_numbers
from recordings.formats.json_tables import is_json, read_json_table
from recordings.formats.line_forms import line_form, rewritten
from recordings.formats.unpacked import open_text

TEXT_SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".log", ".asc", ".tab", ".mtb", ".yaml", ".yml")
EXPECTED = "a table of numbers"
MOST_CHATTER = 0.2
"""Part of a file's lines that may be no rows of it."""
SAMPLE_LINES, SAMPLE_BYTES = 400, 1 << 18
_NA = sorted({spelt for word in MISSING for spelt in (word, word.upper(), word.title())} | {"NaN"})
_SKIPPED = re.compile(r"Skipping line (\d+): expected \d+ fields, saw \d+")
_NAMES = {"\t": "tabs", ";": "semicolons", "|": "bars", " ": "blanks", ",": "commas"}


def read_text_table(
    path: Path, where: str, *, header: Sequence[str] | None = None
) -> list[SourceTable]:
    """Read a text as a table.

    Parameters
    ----------
    header : names of its columns, where the file has none

    Raises
    ------
    InputError
        If it is empty, no line of it is a row of numbers, its header does not fit its rows, or
        it is larger than `models.limits.LIMITS` allows.
    """
    file, encoding = open_text(path, where, EXPECTED)
    with ExitStack() as opened:
        opened.enter_context(file)
        start = file.tell()
        if not file.read(1):
            raise InputError(f"{where} is empty (zero bytes), expected a header and samples")
        file.seek(start)
        lines = list(islice(_lines(file.read(SAMPLE_BYTES)), SAMPLE_LINES))
        if sum(map(is_json, lines)) > 0.5 * len(lines):
            return read_json_table(path, where, header=header)
        form = line_form(lines)
        if form is not None:
            file.seek(start)
            file, start = opened.enter_context(rewritten(file, form)), 0
            lines = list(form.rows(lines))
            header = header or form.names
        dialect = sniffed(lines)
        if dialect is None:
            raise InputError(
                f"{where}: no line of its first {len(lines)} is a row of numbers, "
                f"expected {EXPECTED}"
            )
        names = _names(dialect, header, lines, where)
        file.seek(start)
        delimiters = b" \t" if dialect.delimiter == " " else dialect.delimiter.encode()
        check_most("columns", dialect.columns, where)
        file.seek(start)
        above = dialect.first_line if _at_line(file, dialect.first_line) else 0
        blanks = check_cells(
            file, dialect.columns, where, delimiters=delimiters, start=file.tell(), above=above
        )  # a comment above the rows may be longer than a cell
        file.seek(start)
        frame, longer = _frame(file, dialect, names, where, blanks=blanks)
    frame, short = _without_chatter(respelt(frame, dialect.decimal))
    unnamed = [n for n in frame.columns if n.startswith("column ") and frame[n].isna().all()]
    frame = frame.drop(columns=[] if header else unnamed)
    said, repairs = [*_said(dialect, encoding), *(form.said if form else ())], []
    if longer + short:
        lines_out = counted(longer + short, "line")
        repairs.append(f"{lines_out} left out, no row of {dialect.columns} cells")
    return [
        SourceTable(
            path.name, frame, dialect.preamble, tuple(said), tuple(repairs),
            dialect.header is not None and header is None,
        )
    ]  # fmt: skip


def _lines(sample: bytes) -> list[str]:
    """Return the whole lines of a sample."""
    lines = sample.decode("utf-8", "replace").splitlines()
    return lines[:-1] if len(sample) == SAMPLE_BYTES and len(lines) > 1 else lines


def _names(
    dialect: Dialect, header: Sequence[str] | None, lines: Sequence[str], where: str
) -> list[str]:
    """Return a name of its own for each column."""
    found = dialect.header if header is None else header
    if found is None:
        above = lines[dialect.first_line - 1] if dialect.first_line else ""
        n = len(split_cells(above, dialect.delimiter))
        if n > 1:
            raise InputError(
                f"{where}: its header has {n} cells and its first row {dialect.columns}, "
                "expected as many"
            )
        found = [str(k) for k in range(1, dialect.columns + 1)]
    if len(found) > dialect.columns:
        raise InputError(
            f"{where}: {len(found)} names for {dialect.columns} columns, expected one for each"
        )
    names: list[str] = []
    for k in range(dialect.columns):
        name = (found[k] if k < len(found) else "").strip() or f"column {k + 1}"
        check_most("cell_bytes", len(name), f"{where}: column {value_text(name)}")
        names.append(name if name not in names else f"{name} ({k + 1})")
    return names


def _frame(
    file: BinaryIO, dialect: Dialect, names: list[str], where: str, *, blanks: bool
) -> tuple[pd.DataFrame, int]:
    """Return the rows, and how many lines had too many cells."""
    above = 0 if _at_line(file, dialect.first_line) else dialect.first_line
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            frame = pd.read_csv(
                file,
                sep=r"\s+" if dialect.delimiter == " " else dialect.delimiter,
                decimal=dialect.decimal,
                header=None,
                names=names,
                skiprows=above,
                index_col=False,
                na_values=_NA,
                skipinitialspace=blanks,  # which costs a third of the reading
                on_bad_lines="warn",
                encoding_errors="replace",
            )
        except (ValueError, pd.errors.ParserError) as error:
            raise InputError(f"{where}: cannot be read, expected {EXPECTED}") from error
    return frame, sum(len(_SKIPPED.findall(str(each.message))) for each in caught)


def _at_line(file: BinaryIO, line: int) -> bool:
    """Go to a line of a text, where that is plain: pandas takes half as long again to skip one.

    It is not where a line is quoted across an end of lines, or ends in a carriage return alone.
    """
    start = file.tell()
    for _ in range(line):
        text = file.readline()
        if text.count(b'"') % 2 or b"\r" in text.removesuffix(b"\r\n"):
            file.seek(start)
            return False
    return True


def _without_chatter(frame: pd.DataFrame) -> tuple[pd.DataFrame, int]:
    """Leave out rows that are lines of words, and the last where it was cut off."""
    columns = [cells for _, cells in frame.items()]
    if all(cells.dtype.kind in "iuf" and not cells.hasnans for cells in columns):
        return frame, 0
    n, found = len(frame), np.zeros(len(frame), dtype=int)
    for cells in columns:
        is_number = pd.api.types.is_numeric_dtype(cells)
        found += ~np.isnan(cells.to_numpy(float) if is_number else loose_numbers(cells))
    # A line of words has no number, and one that was cut off early a time at most.
    dropped = found < min(2, len(columns) - 1)
    if n and dropped.mean() > MOST_CHATTER:  # then these are its rows
        dropped[:] = False
    dropped |= np.all([cells.isna() for cells in columns], axis=0)
    if n > 1 and not dropped[-1]:
        before, last = np.array([cells.iloc[-2:].isna() for cells in columns], dtype=bool).T
        if last[-1] and not before[-1] and last.sum() > before.sum():
            dropped[-1] = True
    if not dropped.any():
        return frame, 0
    return frame[~dropped].reset_index(drop=True).infer_objects(), int(dropped.sum())


def _said(dialect: Dialect, encoding: str) -> list[str]:
    parts = []
    if dialect.delimiter != ",":
        parts.append(f"cells separated by {_NAMES[dialect.delimiter]}")
    if dialect.decimal != ".":
        parts.append("decimal comma")
    if encoding != "utf-8":
        parts.append(f"encoding {encoding}")
    if dialect.preamble.strip():
        parts.append(f"{len(dialect.preamble.splitlines())} lines before the header skipped")
    return [", ".join(parts)] if parts else []
