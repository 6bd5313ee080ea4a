"""Tables that are written some rows at a time, as CSV or Parquet."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from types import TracebackType
from typing import IO

import pandas as pd
import pyarrow as pa
import pyarrow.parquet

from models.version import version_metadata

GROUP_ROWS = 50_000
"""Rows of a group of a Parquet file: more compress better, and are kept until they are written."""


class TableWriter:
    """Writes the rows of one table into an open file; all parts have the same columns.

    Parameters
    ----------
    suffix : ``.csv`` or ``.parquet``, which says with which version it is written
    """

    def __init__(self, file: IO[bytes], suffix: str) -> None:
        self._file, self._is_csv = file, suffix == ".csv"
        self._has_header = False
        self._parquet: pyarrow.parquet.ParquetWriter | None = None
        self._waiting: list[pa.Table] = []

    def write(self, table: pd.DataFrame) -> None:
        """Write the next rows, or none of them."""
        if self._is_csv:
            table.to_csv(self._file, index=False, header=not self._has_header)
            self._has_header = True
            return
        arrow = pa.Table.from_pandas(table, preserve_index=False)
        if self._parquet is None:
            metadata = {**(arrow.schema.metadata or {}), **version_metadata()}
            schema = arrow.schema.with_metadata(metadata)
            self._parquet = pyarrow.parquet.ParquetWriter(self._file, schema)
        self._waiting.append(arrow)
        if sum(map(len, self._waiting)) >= GROUP_ROWS:
            self._write_group()

    def _write_group(self) -> None:
        if self._parquet is not None and self._waiting:
            rows = pa.concat_tables(self._waiting).cast(self._parquet.schema)
            self._parquet.write_table(rows)
            self._waiting.clear()

    def __enter__(self) -> TableWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write what waits; after an exception nothing counts that was written."""
        if kind is None:
            self._write_group()
        if self._parquet is not None:
            with suppress(OSError, pa.ArrowException) if kind else nullcontext():
                self._parquet.close()
