"""CSV files from elsewhere: a header, and as many cells in every row."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO

import pandas as pd

from models.errors import InputError
from models.limits import check_most, most, variable
from models.regular_files import open_regular
from models.shown_text import value_text
from recordings.formats.cell_limits import check_cells


def read_csv(path: Path, where: str) -> pd.DataFrame:
    """Read a CSV file.

    Raises
    ------
    InputError
        If it is empty, larger than `models.limits.LIMITS` allows, its header is none, or a row has
        another number of cells; the message names the line.
    """
    with open_regular(path, where, "a table", "table_bytes") as file, _refused(where):
        header = read_header(file, where)
        check_cells(file, len(header), where)
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            table: pd.DataFrame = pd.read_csv(file, **_OPTIONS)
        return table


class CsvParts:
    """A CSV file whose rows are read some at a time, as often as one likes.

    Parameters
    ----------
    file : open, and looked through at once; of any size
    where : for messages

    Raises
    ------
    InputError
        As for `read_csv`, but for its size.
    """

    def __init__(self, file: BinaryIO, where: str) -> None:
        self._file, self._where = file, where
        with _refused(where):
            self.headers = read_header(file, where)
            check_cells(file, len(self.headers), where, limits=())
        self._bytes = file.seek(0, os.SEEK_END)

    def tables(self, rows: int) -> Iterator[tuple[pd.DataFrame, float]]:
        """Yield tables of so many rows, and which fraction of the file is read by then."""
        self._file.seek(0)
        with _refused(self._where), pd.read_csv(self._file, chunksize=rows, **_OPTIONS) as reader:
            while (table := _next(reader)) is not None and len(table):
                yield table, self._file.tell() / self._bytes


def _next(reader: Iterator[pd.DataFrame]) -> pd.DataFrame | None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", pd.errors.ParserWarning)
        return next(reader, None)


_OPTIONS: Mapping[str, Any] = MappingProxyType(
    {
        "keep_default_na": False,
        "na_values": [""],
        "index_col": False,  # where row 1 is longer than the header, pandas warns and drops its end
        "low_memory": False,
    }
)


@contextmanager
def _refused(where: str) -> Iterator[None]:
    """Raise `InputError` for what pandas says of a file."""
    try:
        yield
    except pd.errors.ParserWarning:
        raise InputError(
            f"{where}: row 1 has more cells than the header, expected as many"
        ) from None
    except InputError:
        raise
    except ValueError as error:
        ragged = re.search(r"Expected (\d+) fields in line (\d+), saw (\d+)", str(error))
        if ragged:
            cells, line, found = ragged.groups()
            raise InputError(
                f"{where}: line {line} of the file has {found} cells, "
                f"expected {cells} as in the header"
            ) from None
        raise InputError(f"{where}: cannot be read, expected a csv table") from error


def check_header(header: Sequence[str], where: str) -> None:
    """Raise `InputError` unless every column has a name of its own."""
    if len(header) == 1:
        raise InputError(
            f"{where}: a single column, expected several (a CSV separates them by commas)"
        )
    seen: set[str] = set()
    for number, column in enumerate(header, 1):
        if not column:
            raise InputError(f"{where}: column {number} has no name, expected one in the header")
        if column in seen:
            raise InputError(f"{where}: column {column} appears twice, expected it once")
        check_most("cell_bytes", len(column), f"{where}: column {value_text(column)}")
        seen.add(column)


_PLAIN_HEADER = re.compile(rb"[!#-~][ !#-~]*\r?\n")
"""A line that means the same whoever splits it at commas, which takes pandas a millisecond."""


def read_header(file: BinaryIO, where: str) -> list[str]:
    """Return the names in the first line; pandas would rename those that appear twice.

    Raises
    ------
    InputError
        If there is no line, it is longer than the limits allow, or a column has no name of its own.
    """
    bytes_of_all = most("columns") * (most("cell_bytes") + 1)
    line = file.readline(bytes_of_all + 1)
    if not line:
        raise InputError(f"{where} is empty (zero bytes), expected a header and samples")
    if len(line) > bytes_of_all:
        raise InputError(
            f"{where}: its first line is longer than {bytes_of_all} bytes, expected the names of "
            f"at most {most('columns')} columns ({variable('columns')} sets another limit)"
        )
    check_most("columns", line.count(b",") + 1, where)
    if _PLAIN_HEADER.fullmatch(line):
        header = line.decode().rstrip("\r\n").split(",")
    else:
        file.seek(0)
        first = pd.read_csv(file, header=None, nrows=1, dtype=str, keep_default_na=False)
        header = [str(column) for column in first.iloc[0]]
    file.seek(0)
    check_header(header, where)
    return header
