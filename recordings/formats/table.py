"""The formats of recordings, a row each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from models.errors import InputError
from models.pen_config import PenConfig
from recordings.asked import Asked
from recordings.foreign.source_table import SourceTable
from recordings.formats.bundles import ZIP_SUFFIXES, read_folder, read_zip
from recordings.formats.dpoint import is_dpoint_folder, load_dpoint
from recordings.formats.excel import EXCEL_SUFFIXES, read_excel
from recordings.formats.json_tables import JSON_SUFFIXES, read_json_table
from recordings.formats.own_tables import has_own_columns, read_parquet_table
from recordings.formats.ros_bags import is_bag, read_ros_bag
from recordings.formats.table_stream import TableStream, table_stream
from recordings.formats.tables import load_table
from recordings.formats.text_tables import TEXT_SUFFIXES, read_text_table
from recordings.written import WrittenRecording


class Parser(Protocol):
    """Reads the tables of a file, whatever their columns mean."""

    def __call__(
        self, path: Path, where: str, /, *, header: Sequence[str] | None = None
    ) -> list[SourceTable]:
        """Return the tables; `header` names the columns of one that has none."""


Reader = Callable[[Path, PenConfig, Asked], WrittenRecording]
"""Reads a recording of a pen that is one by its columns' names, or refuses it."""


class Opener(Protocol):
    """Opens a recording of a format to be read in parts."""

    def __call__(
        self, path: Path, pen: PenConfig, /, *, units: Mapping[str, str] | None = None
    ) -> AbstractContextManager[TableStream]:
        """Return the recording as a context; `units` are for what says none by itself."""


@dataclass(frozen=True)
class RecordingFormat:
    """A format.

    Parameters
    ----------
    name : as in ``expected a D-POINT folder, .csv or .parquet``
    recognises : whether a path that exists looks like it
    tables : reads its tables; None for a format that is no table
    read : reads one of this project's own, or refuses it; None where it writes none such
    stream : opens one of this project's own to be read in parts; None for what is read whole
    pen : bundled pen that all recordings of the format are of; None where they are of any
    """

    name: str
    recognises: Callable[[Path], bool]
    tables: Parser | None = None
    read: Reader | None = None
    stream: Opener | None = None
    pen: str | None = None

    def is_own(self, path: Path, pen: PenConfig, asked: Asked) -> bool:
        """Whether `read_own` is for a path: its columns' names are those of a pen's recording."""
        if self.read is None or self.tables is None:
            return self.tables is None
        return not asked.is_of_others and has_own_columns(path, pen)

    def read_own(self, path: Path, pen: PenConfig, asked: Asked) -> WrittenRecording:
        """Read a recording of this project's own.

        Raises
        ------
        InputError
            If it is none.
        """
        if self.read is None:
            raise InputError(f"recording {path}: {self.name}, expected columns of its own")
        return self.read(path, pen, asked)


def _load_dpoint(path: Path, pen: PenConfig, asked: Asked) -> WrittenRecording:
    if asked.columns or asked.header:
        raise InputError(f"recording {path}: columns are given for a D-POINT folder, expected none")
    return load_dpoint(path, pen, units=asked.units)


def _load_table(path: Path, pen: PenConfig, asked: Asked) -> WrittenRecording:
    return load_table(path, pen, units=asked.units)


def _read_folder(
    path: Path, where: str, /, *, header: Sequence[str] | None = None
) -> list[SourceTable]:
    return read_folder(path, where, header=header, parse=tables_of)


def _read_zip(
    path: Path, where: str, /, *, header: Sequence[str] | None = None
) -> list[SourceTable]:
    return read_zip(path, where, header=header, parse=tables_of)


def _ends_in(*suffixes: str) -> Callable[[Path], bool]:
    """Return whether a path's name ends so, packed by gzip or not."""
    return lambda path: path.name.casefold().removesuffix(".gz").endswith(suffixes)


FORMATS: tuple[RecordingFormat, ...] = (
    RecordingFormat("a folder of tables", Path.is_dir, _read_folder),
    RecordingFormat("a D-POINT folder", is_dpoint_folder, read=_load_dpoint, pen="dpoint"),
    RecordingFormat(".txt or .tsv", _ends_in(*TEXT_SUFFIXES), read_text_table),
    RecordingFormat(".json", _ends_in(*JSON_SUFFIXES), read_json_table),
    RecordingFormat(
        ".csv", lambda path: path.suffix == ".csv", read_text_table, _load_table, table_stream
    ),
    RecordingFormat(
        ".parquet",
        lambda path: path.suffix == ".parquet",
        read_parquet_table,
        _load_table,
        table_stream,
    ),
    RecordingFormat(".xlsx", _ends_in(*EXCEL_SUFFIXES), read_excel),
    RecordingFormat(".zip", _ends_in(*ZIP_SUFFIXES), _read_zip),
    RecordingFormat("a ROS bag", is_bag, read_ros_bag),
)
"""A format exists with its row here; of several that recognise a path, the last reads it."""


def format_names(formats: Iterable[RecordingFormat] = FORMATS) -> str:
    """Return the names in a sentence: ``a D-POINT folder, .csv or .parquet``."""
    *names, last = (row.name for row in formats)
    return f"{', '.join(names)} or {last}"


def format_of(path: Path) -> RecordingFormat | None:
    """Return the format of a path that exists; None where none recognises it."""
    return next((row for row in reversed(FORMATS) if row.recognises(path)), None)


def tables_of(
    path: Path, where: str, *, header: Sequence[str] | None = None
) -> list[SourceTable] | None:
    """Return the tables of a path that exists; None where no format of tables recognises it."""
    row = format_of(path)
    return None if row is None or row.tables is None else row.tables(path, where, header=header)
