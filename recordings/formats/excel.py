"""Excel workbooks (.xlsx, .xlsm, .xlsb, .xls) and OpenDocument sheets, a table a sheet.

Read by `python-calamine <https://pypi.org/project/python-calamine>`_, an extra: ECMA-376 for
.xlsx, [MS-XLS] for .xls, OASIS OpenDocument for .ods. Sheets without a row of numbers are left out.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Sequence
from itertools import chain, islice
from pathlib import Path

import numpy as np
import pandas as pd

from models.errors import InputError
from models.limits import check_most
from models.regular_files import open_regular
from recordings.foreign.sniffing import is_number, sniffed_header
from recordings.foreign.source_table import SourceTable

EXCEL_SUFFIXES = (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")
EXPECTED = "an Excel workbook with a sheet of samples"
ROWS_ABOVE = 50
"""Rows above the samples of a sheet, at most."""
PART_ROWS = 20_000
"""Rows that become columns at once."""


def read_excel(path: Path, where: str, *, header: Sequence[str] | None = None) -> list[SourceTable]:
    """Read the sheets of a workbook.

    Parameters
    ----------
    header : names of the columns of a sheet that has none

    Raises
    ------
    InputError
        If it cannot be read, has no sheet of numbers, is larger than `models.limits.LIMITS`
        allows, or the reader of such files is not installed.
    """
    try:
        from python_calamine import CalamineWorkbook
    except ImportError:
        raise InputError(
            f"{where}: reading it needs python-calamine, expected pip install 'pen-mhe[excel]'"
        ) from None
    try:
        with open_regular(path, where, EXPECTED, "table_bytes") as file:
            if zipfile.is_zipfile(file):
                with zipfile.ZipFile(file) as parts:
                    unpacked = sum(part.file_size for part in parts.infolist())
                    check_most("unpacked_bytes", unpacked, where)
        with CalamineWorkbook.from_path(str(path)) as book:
            found = []
            check_most("members", len(book.sheet_names), where)
            for name in book.sheet_names:
                sheet = book.get_sheet_by_name(name)
                check_most("columns", sheet.total_width, f"{where}: sheet {name}")
                check_most("rows", sheet.total_height, f"{where}: sheet {name}")
                above = 0 if sheet.start is None else sheet.start[0]
                found.append(_table(name, islice(sheet.iter_rows(), above, None), header))
    except InputError:
        raise
    except Exception as error:  # whatever a damaged workbook makes of itself
        raise InputError(f"{where}: cannot be read, expected {EXPECTED}") from error
    tables = [table for table in found if table is not None]
    if not tables:
        raise InputError(f"{where}: no sheet has a row of numbers, expected {EXPECTED}")
    return tables


def _table(
    name: str, rows: Iterator[Sequence[object]], header: Sequence[str] | None
) -> SourceTable | None:
    begin = list(islice(rows, ROWS_ABOVE))
    texts = [[_text(cell) for cell in row] for row in begin]
    first = next((i for i, row in enumerate(texts) if _is_data(row)), None)
    if first is None:
        return None
    names = sniffed_header(texts, first) if header is None else tuple(header)
    columns = len(texts[first])
    if len(names or ()) > columns:
        return None
    spelt = list(names or map(str, range(1, columns + 1)))
    spelt += [""] * (columns - len(spelt))
    unique = [
        n if n and n not in spelt[:k] else f"{n or 'column'} {k + 1}" for k, n in enumerate(spelt)
    ]
    frame = _frame(chain(begin[first:], rows), unique).dropna(how="all")
    preamble = "\n".join(" ".join(row) for row in texts[:first])
    has_header = names is not None and header is None
    return SourceTable(name, frame.reset_index(drop=True), preamble, has_header=has_header)


def _frame(rows: Iterator[Sequence[object]], names: Sequence[str]) -> pd.DataFrame:
    """Return rows, at least one, as columns: a number of Python's for each cell is kept of few."""
    parts = []
    while part := list(islice(rows, PART_ROWS)):
        cells = pd.DataFrame(part, columns=list(names))
        parts.append(cells.replace("", np.nan).infer_objects())
    return pd.concat(parts, ignore_index=True).infer_objects()


def _text(cell: object) -> str:
    return str(cell).strip()


def _is_data(cells: Sequence[str]) -> bool:
    told = [cell for cell in cells if cell]
    return len(told) > 1 and sum(map(is_number, told)) >= 0.5 * len(told)
