"""Any recording that the command line takes: a D-POINT folder, CSV or Parquet."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from estimation.recording import Recording
from models.errors import InputError
from models.pen_file import AnyPen, as_pen
from recordings.formats.columns import column_units
from recordings.formats.dpoint import CAMERA_FILE, STYLUS_FILE, is_dpoint_folder
from recordings.formats.tables import read_table, recording_from_table
from recordings.plausible_units import check_units
from recordings.written import WrittenRecording, load_dpoint


def read_recording(
    path: str | Path, pen: AnyPen, *, units: Mapping[str, str] | None = None
) -> Recording:
    """Read a recording of a pen's sensors; see `read_written`, which brings its ink too."""
    return read_written(path, pen, units=units).recording


def read_written(
    path: str | Path, pen: AnyPen, *, units: Mapping[str, str] | None = None
) -> WrittenRecording:
    """Read a recording of a pen's sensors with the ink that it left.

    Parameters
    ----------
    path : a D-POINT folder, or a CSV or Parquet file
    pen : a pen, the name of a bundled one, or the path of a pen file
    units : sensor name → unit, for tables whose headers have none

    Raises
    ------
    InputError
        If it does not exist, does not fit the pen, has a single sample, or only
        makes sense in other units; see `recordings.plausible_units`.
    """
    path, config = Path(path), as_pen(pen)
    if not path.exists():
        raise InputError(
            f"recording {path} does not exist, expected a D-POINT folder, .csv or .parquet"
        )
    if path.is_dir():
        if not is_dpoint_folder(path):
            raise InputError(
                f"recording {path} is a folder without D-POINT's files, expected "
                f"{STYLUS_FILE} and {CAMERA_FILE}"
            )
        if units:
            raise InputError(
                f"recording {path}: units are given for a D-POINT folder, expected none: its are SI"
            )
        loaded = load_dpoint(path, config)
    else:
        table = read_table(path)
        recording = recording_from_table(table, config, str(path), units)
        check_units(recording, config, column_units(table.columns, config, units))
        loaded = WrittenRecording(recording)
    if len(loaded.recording.time_s) < 2:
        raise InputError(f"recording {path} has a single sample, expected at least two")
    return loaded
