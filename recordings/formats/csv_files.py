"""CSV files from elsewhere: a header, and as many cells in every row."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

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
    with open_regular(path, where, "a table", "table_bytes") as file:
        if not file.read(1):
            raise InputError(f"{where} is empty (zero bytes), expected a header and samples")
        file.seek(0)
        try:
            header = _header(file, where)
            check_header(header, where)
            check_cells(file, len(header), where)
            return _table(file)
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


def _header(file: BinaryIO, where: str) -> list[str]:
    """Return the names in the first line; pandas would rename those that appear twice."""
    bytes_of_all = most("columns") * (most("cell_bytes") + 1)
    line = file.readline(bytes_of_all + 1)
    if len(line) > bytes_of_all:
        raise InputError(
            f"{where}: its first line is longer than {bytes_of_all} bytes, expected the names of "
            f"at most {most('columns')} columns ({variable('columns')} sets another limit)"
        )
    check_most("columns", line.count(b",") + 1, where)
    file.seek(0)
    first = pd.read_csv(file, header=None, nrows=1, dtype=str, keep_default_na=False)
    file.seek(0)
    return [str(column) for column in first.iloc[0]]


def _table(file: BinaryIO) -> pd.DataFrame:
    with warnings.catch_warnings():
        # Where row 1 is longer than the header, pandas would drop its end.
        warnings.simplefilter("error", pd.errors.ParserWarning)
        return pd.read_csv(
            file, keep_default_na=False, na_values=[""], index_col=False, low_memory=False
        )
