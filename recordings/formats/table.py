"""The formats of recordings, a row each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from models.pen_config import PenConfig
from recordings.formats.dpoint import load_dpoint
from recordings.formats.table_stream import TableStream, table_stream
from recordings.formats.tables import load_table
from recordings.written import WrittenRecording


class Reader(Protocol):
    """Reads a recording of a format."""

    def __call__(
        self, path: Path, pen: PenConfig, /, *, units: Mapping[str, str] | None = None
    ) -> WrittenRecording:
        """Return the recording; `units` are for what says none by itself."""


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
    read : takes path and pen, and ``units``: sensor name → unit, for what says none by itself
    stream : opens it to be read in parts; None for what is read whole
    """

    name: str
    recognises: Callable[[Path], bool]
    read: Reader
    stream: Opener | None = None


FORMATS: tuple[RecordingFormat, ...] = (
    RecordingFormat("a D-POINT folder", Path.is_dir, load_dpoint),
    RecordingFormat(".csv", lambda path: path.suffix == ".csv", load_table, table_stream),
    RecordingFormat(".parquet", lambda path: path.suffix == ".parquet", load_table, table_stream),
)
"""A format exists with its row here; of several that recognise a path, the last reads it."""


def format_names(formats: Iterable[RecordingFormat] = FORMATS) -> str:
    """Return the names in a sentence: ``a D-POINT folder, .csv or .parquet``."""
    *names, last = (row.name for row in formats)
    return f"{', '.join(names)} or {last}"


def format_of(path: Path) -> RecordingFormat | None:
    """Return the format of a path that exists; None where none recognises it."""
    return next((row for row in reversed(FORMATS) if row.recognises(path)), None)
