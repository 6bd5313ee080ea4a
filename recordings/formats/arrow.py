"""Parquet files from elsewhere."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import pyarrow as pa
import pyarrow.parquet

from models.border import reading
from models.errors import InputError
from models.limits import check_most
from models.regular_files import open_regular


def read_arrow(path: Path, where: str, expected: str) -> pa.Table:
    """Read a Parquet file as its columns, whatever pandas wrote beside them.

    Raises
    ------
    InputError
        If it is none, is damaged, or is larger than `models.limits.LIMITS` allows.
    """
    with (
        reading(where, expected),
        open_regular(path, where, expected, "table_bytes") as file,
    ):
        parquet = _opened(file, where, expected)
        rows, columns = parquet.metadata.num_rows, parquet.metadata.num_columns
        check_most("rows", rows, where)
        check_most("values", rows * columns, where)
        with _refused(where, expected):
            # What pandas says of its own columns may be damaged, and is not needed.
            found = parquet.read(use_pandas_metadata=False).replace_schema_metadata(None)
            found.validate(full=True)  # texts that are none
            return found


def read_headers(path: Path, where: str, expected: str) -> list[str]:
    """Return the names of a Parquet file's own columns.

    Raises
    ------
    InputError
        If it is none or is damaged.
    """
    with reading(where, expected), open_regular(path, where, expected, None) as file:
        names = _opened(file, where, expected).schema_arrow.names
    return [names[i] for i in own_columns(names)]


class ArrowParts:
    """A Parquet file whose rows are read some at a time, as often as one likes.

    Parameters
    ----------
    file : open; of any size
    where, expected : for messages

    Raises
    ------
    InputError
        If it is none or is damaged.
    """

    def __init__(self, file: BinaryIO, where: str, expected: str) -> None:
        self._where, self._expected = where, expected
        self._parquet = _opened(file, where, expected)
        self.headers: list[str] = self._parquet.schema_arrow.names

    def tables(self, rows: int) -> Iterator[tuple[pa.Table, float]]:
        """Yield tables of so many rows, and which fraction of the file is read by then."""
        read, all_rows = 0, self._parquet.metadata.num_rows
        with _refused(self._where, self._expected):
            for batch in self._parquet.iter_batches(rows, use_pandas_metadata=False):
                table = pa.Table.from_batches([batch]).replace_schema_metadata(None)
                table.validate(full=True)
                read += len(table)
                if len(table):
                    yield table, read / all_rows


def _opened(file: BinaryIO, where: str, expected: str) -> pyarrow.parquet.ParquetFile:
    if not file.read(1):
        raise InputError(f"{where} is empty (zero bytes), expected a header and samples")
    file.seek(0)
    with _refused(where, expected):
        # A column of a group of rows at a time, and not all that a file holds of it.
        parquet = pyarrow.parquet.ParquetFile(
            file, thrift_string_size_limit=10**8, pre_buffer=False, buffer_size=1 << 20
        )
    check_most("columns", parquet.metadata.num_columns, where)
    return parquet


@contextmanager
def _refused(where: str, expected: str) -> Iterator[None]:
    """Raise `InputError` for what pyarrow says of a file."""
    try:
        yield
    except InputError:
        raise
    except (pa.ArrowException, ValueError, OSError) as error:
        raise InputError(f"{where}: cannot be read, expected {expected}") from error


def own_columns(names: Sequence[str]) -> list[int]:
    """Return which columns are a table's own: not rows that pandas has counted or named."""
    return [i for i, name in enumerate(names) if not _PANDAS_INDEX.fullmatch(name)]


_PANDAS_INDEX = re.compile(r"__index_level_\d+__")


def with_types(
    table: pa.Table, schema: pa.Schema, where: str, *, filled: Iterable[str] = ()
) -> pa.Table:
    """Return the columns of a schema, with its types.

    Parameters
    ----------
    filled : columns that have no empty cells

    Raises
    ------
    InputError
        If a column is missing, holds something else or has an empty cell that it must not have.
    """
    found = {}
    for field in schema:
        if field.name not in table.column_names:
            raise InputError(
                f"{where} has no column {field.name}, expected {', '.join(schema.names)}"
            )
        column = table[field.name]
        if field.name in filled and column.null_count:
            raise InputError(f"{where}: column {field.name} has empty cells, expected none")
        try:
            found[field.name] = column.cast(field.type)
        except pa.ArrowException:
            raise InputError(
                f"{where}: column {field.name} has {column.type}, expected {field.type}"
            ) from None
    return pa.table(found, schema)
