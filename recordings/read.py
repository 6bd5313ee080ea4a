"""Any recording that the command line takes, of any of the formats."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from estimation.recording import Recording
from models.border import reading
from models.errors import InputError
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen
from models.state_space import StateSpaceModel
from recordings.formats.model_tables import recording_from_model_table
from recordings.formats.table import FORMATS, format_names, format_of
from recordings.written import WrittenRecording


def read_recording(
    path: str | Path | pd.DataFrame,
    pen: AnyPen | StateSpaceModel,
    *,
    units: Mapping[str, str] | None = None,
) -> Recording:
    """Read a recording of a pen's sensors; see `read_written`, which brings its ink too.

    Of a model of one's own it reads a table, `recordings.formats.model_tables`, in its units, or
    takes one that is already there.

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
            return recording_from_model_table(read_table(Path(path)), pen, str(path))
    return read_written(path, pen, units=units).recording


def read_written(
    path: str | Path, pen: AnyPen, *, units: Mapping[str, str] | None = None
) -> WrittenRecording:
    """Read a recording of a pen's sensors with the ink that it left.

    Parameters
    ----------
    path : of one of `recordings.formats.table.FORMATS`
    pen : a pen, the name of a bundled one, or the path of a pen file
    units : sensor name → unit, for tables whose headers have none

    Raises
    ------
    InputError
        If it does not exist, does not fit the pen, has a single sample, or only
        makes sense in other units; see `recordings.plausible_units`.
    """
    config = as_pen(pen)
    with reading(f"recording {path}", format_names()):
        return _read(Path(path), config, units or {})


def _read(path: Path, config: PenConfig, units: Mapping[str, str]) -> WrittenRecording:
    if not path.exists():
        raise InputError(f"recording {path} does not exist, expected {format_names()}")
    row = format_of(path)
    if row is None:
        suffixes_first = sorted(FORMATS, key=lambda row: not row.name.startswith("."))
        raise InputError(
            f"recording {path}: suffix {path.suffix or '(none)'} is unknown, "
            f"expected {format_names(suffixes_first)}"
        )
    loaded = row.read(path, config, units=units)
    if len(loaded.recording.time_s) < 2:
        raise InputError(f"recording {path} has a single sample, expected at least two")
    return loaded
