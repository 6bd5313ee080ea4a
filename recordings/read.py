"""Any recording that the command line takes, of any of the formats."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

import pandas as pd

from estimation.recording import Recording
from models.border import reading
from models.errors import InputError
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen
from models.state_space import StateSpaceModel
from recordings.asked import Asked, ColumnsAsked
from recordings.foreign.recognise import recording_of_tables
from recordings.foreign.source_table import SourceTable
from recordings.formats.model_tables import recording_from_model_table
from recordings.formats.table import FORMATS, RecordingFormat, format_names, format_of
from recordings.formats.table_stream import TableStream
from recordings.written import WrittenRecording

RecordingPath = str | Path | Sequence[str | Path]
"""Path of a recording, or paths of the files that are one together."""


def read_recording(
    path: RecordingPath | pd.DataFrame,
    pen: AnyPen | StateSpaceModel,
    *,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
    strict: bool = False,
) -> Recording:
    """Read a recording of a pen's sensors; see `read_written`, which brings its ink too.

    What was recognised, ignored and repaired in a file of somebody else's, and what checks find
    (`recordings.checked.check`), goes to standard error, a sentence a line. Of a model of one's own
    it reads a table, `recordings.formats.model_tables`, in its units, or takes one that is
    already there.

    Raises
    ------
    InputError
        If it is a table of a pen's readings, or `read_written` refuses it.
    """
    if isinstance(path, pd.DataFrame):
        if not isinstance(pen, StateSpaceModel):
            raise InputError("a table of a pen's readings, expected the path of a recording")
        return recording_from_model_table(path, pen, "table")
    if isinstance(pen, StateSpaceModel):
        from recordings.formats.tables import read_table

        with reading(f"recording {path}", "a table of the model's readings"):
            if not isinstance(path, str | Path):
                raise InputError("several files of a model's readings, expected one table")
            return recording_from_model_table(read_table(Path(path)), pen, str(path))
    written = read_written(path, pen, units=units, columns=columns, strict=strict)
    return _said(written.checked(written.recording, as_pen(pen)))


def read_noted(
    path: RecordingPath, pen: AnyPen, *, units: Mapping[str, str] | None = None
) -> Recording:
    """Read a recording that is none of a pen in use: `read_recording` without its checks.

    Raises
    ------
    InputError
        If `read_written` refuses it.
    """
    return _said(read_written(path, pen, units=units))


def _said(written: WrittenRecording) -> Recording:
    for sentence in written.sentences():
        print(sentence, file=sys.stderr)
    return written.recording


def read_written(
    path: RecordingPath,
    pen: AnyPen,
    *,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
    strict: bool = False,
) -> WrittenRecording:
    """Read a recording of a pen's sensors with the ink that it left.

    A table whose columns are not this project's is read by its headers, units and times, see
    `recordings.foreign`; its notes say what was recognised, ignored and repaired.

    Parameters
    ----------
    path : of one of `recordings.formats.table.FORMATS`, or several of one recording
    pen : a pen, the name of a bundled one, or the path of a pen file
    units : sensor name, or ``time`` → unit, for tables whose headers have none: ``mg``, or
        ``g/16384`` for counts
    columns : sensor name, or ``time`` → its columns: ``"accel=ax,-ay,az;time=millis"``, a minus
        turns a sign; names of all columns for a file without a header
    strict : refuse what would have to be repaired: stamps that repeat or go back, lines that
        are cut off

    Raises
    ------
    InputError
        If it does not exist, does not fit the pen, has a single sample, or only
        makes sense in other units; see `recordings.plausible_units`.
    """
    config, asked = as_pen(pen), Asked.of(units, columns, strict=strict)
    paths = _paths(path)
    name = " and ".join(map(str, paths))
    with reading(f"recording {name}", format_names()):
        loaded = _read(paths, config, asked, name)
        if len(loaded.recording.time_s) < 2:
            raise InputError(f"recording {name} has a single sample, expected at least two")
        return loaded


def in_parts(
    path: RecordingPath,
    pen: PenConfig,
    *,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
) -> AbstractContextManager[TableStream] | None:
    """Return a recording as a context, to be read in parts; None where it must be read whole.

    That is of columns of somebody else's, of several files, or of a format without parts.

    Parameters
    ----------
    path, units, columns : see `read_written`

    Raises
    ------
    InputError
        If it does not exist, or is of no format. Entering it may raise `UnfitTableError`.
    """
    paths, asked = _paths(path), Asked.of(units, columns)
    with reading(f"recording {paths[0]}", format_names()):
        row = _format(paths[0])
        if len(paths) > 1 or row.stream is None or not row.is_own(paths[0], pen, asked):
            return None
    return row.stream(paths[0], pen, units=asked.units)


def _paths(path: RecordingPath) -> list[Path]:
    paths = [Path(path)] if isinstance(path, str | Path) else [Path(one) for one in path]
    if not paths:
        raise InputError("no path of a recording, expected at least one")
    return paths


def _read(paths: Sequence[Path], config: PenConfig, asked: Asked, name: str) -> WrittenRecording:
    rows = [_format(path) for path in paths]
    if len(paths) > 1:
        return _recognised(paths, rows, config, asked, name)
    if not rows[0].is_own(paths[0], config, asked):
        return _recognised(paths, rows, config, asked, name)
    try:
        return rows[0].read_own(paths[0], config, asked)
    except InputError as refused:
        if asked.strict or rows[0].tables is None:
            raise
        try:
            return _recognised(paths, rows, config, asked, name)  # which repairs what it can
        except InputError:
            raise refused from None


def _recognised(
    paths: Sequence[Path],
    rows: Sequence[RecordingFormat],
    config: PenConfig,
    asked: Asked,
    name: str,
) -> WrittenRecording:
    tables: list[SourceTable] = []
    for path, row in zip(paths, rows, strict=True):
        if row.tables is None:
            raise InputError(f"recording {name}: several paths, expected files of tables")
        tables += row.tables(path, f"recording {path}", header=asked.header)
    return recording_of_tables(tables, config, asked, name)


def _format(path: Path) -> RecordingFormat:
    if not path.exists():
        raise InputError(f"recording {path} does not exist, expected {format_names()}")
    row = format_of(path)
    if row is None:
        suffixes_first = sorted(FORMATS, key=lambda row: not row.name.startswith("."))
        raise InputError(
            f"recording {path}: suffix {path.suffix or '(none)'} is unknown, "
            f"expected {format_names(suffixes_first)}"
        )
    return row
