"""A recording in a table that is read some rows at a time, as often as one likes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO, Protocol

import numpy as np
import pandas as pd

from estimation.recording import Recording
from models.border import reading
from models.pen_config import PenConfig
from models.regular_files import open_regular
from recordings.formats.arrow import ArrowParts, own_columns
from recordings.formats.csv_files import CsvParts, check_header
from recordings.formats.table_header import TableHeader
from recordings.unfit import unfit

PART_ROWS = 10_000
"""Rows that are read at once: enough to cost nothing, few enough for their covariances."""


class TableParts(Protocol):
    """An open table."""

    @property
    def headers(self) -> list[str]:
        """Its columns' names."""

    def tables(self, rows: int) -> Iterator[tuple[pd.DataFrame, float]]:
        """Yield tables of so many rows, and which fraction of the file is read by then."""


class ParquetParts:
    """A Parquet file as tables of pandas."""

    def __init__(self, file: BinaryIO, where: str) -> None:
        self._file = ArrowParts(file, where, "a parquet table")
        self._own = own_columns(self._file.headers)
        self.headers = [self._file.headers[i] for i in self._own]
        check_header(self.headers, where)

    def tables(self, rows: int) -> Iterator[tuple[pd.DataFrame, float]]:
        """See `TableParts`."""
        for table, fraction in self._file.tables(rows):
            yield table.select(self._own).to_pandas(), fraction


_OPENED: Mapping[str, Callable[[BinaryIO, str], TableParts]] = MappingProxyType(
    {".csv": CsvParts, ".parquet": ParquetParts}
)


class TableStream:
    """A pen's recording in a table, in parts.

    Parameters
    ----------
    header : what its columns give
    notes : sentences on what is left out
    """

    def __init__(
        self, table: TableParts, header: TableHeader, *, notes: tuple[str, ...] = ()
    ) -> None:
        self._table, self.header, self.notes = table, header, notes

    def parts(self, on_read: Callable[[float], None] | None = None) -> Iterator[Recording]:
        """Yield the recordings of successive rows.

        Parameters
        ----------
        on_read : called with the fraction of the file that is read

        Raises
        ------
        UnfitTableError
            If a cell is not a finite number, or times do not increase.
        """
        above, before_s = 0, -np.inf
        with unfit(), reading(self.header.where, "a table"):
            for table, fraction in self._table.tables(PART_ROWS):
                part = self.header.recording(table, above=above, before_s=before_s)
                above, before_s = above + len(table), float(part.time_s[-1])
                yield part
                if on_read:
                    on_read(fraction)


@contextmanager
def table_stream(
    path: Path, pen: PenConfig, *, units: Mapping[str, str] | None = None
) -> Iterator[TableStream]:
    """Open a CSV or Parquet file of any size; see `recordings.formats.tables.load_table`.

    Of a sensor that may be silent it is read until the first reading, see
    `TableHeader.without_silent`.

    Raises
    ------
    InputError
        If it cannot be opened.
    UnfitTableError
        If its header is none of a recording of the pen.
    """
    where, kind = f"recording {path}", f"a {path.suffix[1:]} table"
    with open_regular(path, where, kind, None) as file:
        with unfit(), reading(where, kind):
            table = _OPENED[path.suffix](file, where)
            header = TableHeader.of(table.headers, pen, str(path), units=units)
            rows = (part for part, _ in table.tables(PART_ROWS))
            header, notes = header.without_silent(pen, rows)
        yield TableStream(table, header, notes=notes)
