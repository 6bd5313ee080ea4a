"""Tables of this project's own, by the names of their columns; Parquet of anybody's."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from models.errors import InputError
from models.limits import most
from models.pen_config import PenConfig
from models.plain_names import plain_name
from models.regular_files import open_regular
from recordings.foreign.source_table import SourceTable
from recordings.formats.arrow import read_headers
from recordings.formats.columns import recording_columns
from recordings.formats.tables import read_table


def read_parquet_table(
    path: Path, where: str, *, header: Sequence[str] | None = None
) -> list[SourceTable]:
    """Read a Parquet file as a table, whatever its columns mean.

    Raises
    ------
    InputError
        If it cannot be read, or a column has no name or that of another.
    """
    return [SourceTable(path.name, read_table(path))]


def has_own_columns(path: Path, pen: PenConfig) -> bool:
    """Whether every column of a CSV or Parquet file is one of a pen's recording, by its name."""
    where = f"recording {path}"
    if path.suffix == ".csv":
        with open_regular(path, where, "a table", None) as file:
            line = file.readline(most("columns") * most("cell_bytes")).decode(
                "utf-8-sig", "replace"
            )
        headers = [cell.strip().strip('"') for cell in line.split(",")]
    else:
        try:
            headers = read_headers(path, where, "a parquet table")
        except InputError:
            return True  # whose reader then says what is wrong
    known = recording_columns(pen, {})
    return all(header in known or plain_name(header) in known for header in headers)
