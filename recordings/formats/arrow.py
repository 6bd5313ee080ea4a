"""Parquet files from elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

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
        if not file.read(1):
            raise InputError(f"{where} is empty (zero bytes), expected a header and samples")
        file.seek(0)
        try:
            parquet = pyarrow.parquet.ParquetFile(file, thrift_string_size_limit=10**8)
            rows, columns = parquet.metadata.num_rows, parquet.metadata.num_columns
            check_most("columns", columns, where)
            check_most("rows", rows, where)
            check_most("values", rows * columns, where)
            # What pandas says of its own columns may be damaged, and is not needed.
            found = parquet.read(use_pandas_metadata=False).replace_schema_metadata(None)
            found.validate(full=True)  # texts that are none
            return found
        except InputError:
            raise
        except (pa.ArrowException, ValueError, OSError) as error:
            raise InputError(f"{where}: cannot be read, expected {expected}") from error


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
