"""Any recording that the command line takes: a D-POINT folder, CSV or Parquet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmark.ink import ink_points_mm
from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen import PenConfig
from models.sensors import Contact, PoseCamera
from pen_mhe.columns import column_units
from pen_mhe.dpoint import CAMERA_FILE, STYLUS_FILE, is_dpoint_folder, read_dpoint
from pen_mhe.plausible_units import check_units
from pen_mhe.tables import read_table, recording_from_table


@dataclass(frozen=True, eq=False)
class Ink:
    """The ink that a recording left, (m, 2) mm, and when the pen pressed: (n,) s, 0 or 1."""

    points_mm: Array
    time_s: Array
    pressed: Array


@dataclass(frozen=True, eq=False)
class LoadedRecording:
    """A recording with the ink it left, where there is a scan."""

    recording: Recording
    ink: Ink | None = None


def load_recording(
    path: Path, pen: PenConfig, units: Mapping[str, str] | None = None
) -> LoadedRecording:
    """Read a recording of a pen's sensors.

    Parameters
    ----------
    path : a D-POINT folder, or a CSV or Parquet file
    units : sensor name → unit, for tables whose headers have none

    Raises
    ------
    InputError
        If it does not exist, does not fit the pen, has a single sample, or only
        makes sense in other units; see `pen_mhe.plausible_units`.
    """
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
        loaded = load_dpoint(path, pen)
    else:
        table = read_table(path)
        recording = recording_from_table(table, pen, str(path), units)
        check_units(recording, pen, column_units(table.columns, pen, units))
        loaded = LoadedRecording(recording)
    if len(loaded.recording.time_s) < 2:
        raise InputError(f"recording {path} has a single sample, expected at least two")
    return loaded


def load_dpoint(folder: Path, pen: PenConfig) -> LoadedRecording:
    """Read a D-POINT folder with the camera delay and pressure threshold of a pen."""
    cameras = [s for s in pen.sensors.values() if isinstance(s, PoseCamera)]
    contacts = [s for s in pen.sensors.values() if isinstance(s, Contact)]
    if len(cameras) != 1 or len(contacts) != 1:
        raise InputError(
            f"pen {pen.name}: expected one pose_camera and one contact to read a D-POINT folder "
            "(its delay_s and pressure_threshold are needed)"
        )
    read = read_dpoint(
        folder, cameras[0].delay_s, contacts[0].pressure_threshold, contacts[0].height_m
    )
    if read.scan is None:
        return LoadedRecording(read.recording)
    pressed = (read.pressure > contacts[0].pressure_threshold).astype(float)
    return LoadedRecording(
        read.recording, Ink(ink_points_mm(read.scan), read.pressure_time_s, pressed)
    )
