"""Reader of D-POINT recordings: a folder with stylus, camera and scan.

Time: the stylus' own clock (integer ms) plus the median offset to the host's;
host stamps of single samples jitter by several ms. Camera frames are stamped
with their capture, the host's stamp minus the camera's delay.

Messages count rows, the elements of a file's list, from 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from estimation.recording import Recording
from models.arrays import Array
from models.border import reading
from models.errors import InputError
from models.limits import check_most
from models.parsed import json_data
from models.pen_config import PenConfig
from models.regular_files import open_regular
from recordings.ink import Ink, ink_points_mm
from recordings.pressure import above_baseline
from recordings.written import WrittenRecording

STYLUS_FILE, CAMERA_FILE, SCAN_FILE = "stylus_data.json", "camera_data.json", "scan.jpg"
ROTATION_TOLERANCE = 1e-3
"""Largest entry of R Rᵀ - I that counts as rounding."""


@dataclass(frozen=True, eq=False)
class DpointFolder:
    """A D-POINT recording.

    Parameters
    ----------
    recording : sensors ``accel``, ``gyro``, ``camera``, ``contact``; zero on the time
        axis is the first stylus sample
    pressure_time_s, pressure : (n,), 0 to 1: raw, or above its baseline
    scan : the scanned sheet, where there is one
    """

    recording: Recording
    pressure_time_s: Array
    pressure: Array
    scan: Path | None


def is_dpoint_folder(path: Path) -> bool:
    """Whether a path is a folder with a stylus and a camera file."""
    return (path / STYLUS_FILE).is_file() and (path / CAMERA_FILE).is_file()


def load_dpoint(
    folder: Path, pen: PenConfig, *, units: Mapping[str, str] | None = None
) -> WrittenRecording:
    """Read a D-POINT folder with the camera delay and pressure threshold of a pen.

    Raises
    ------
    InputError
        If a file is missing or wrong, units are given (its are SI), or the pen has not
        exactly one camera and one contact.
    """
    if not is_dpoint_folder(folder):
        raise InputError(
            f"recording {folder} is a folder without D-POINT's files, expected "
            f"{STYLUS_FILE} and {CAMERA_FILE}"
        )
    if units:
        raise InputError(
            f"recording {folder}: units are given for a D-POINT folder, expected none: its are SI"
        )
    cameras: list[Any] = [s for s in pen.sensors.values() if s.sees_pose]
    contacts: list[Any] = [s for s in pen.sensors.values() if s.reads_touch]
    if len(cameras) != 1 or len(contacts) != 1:
        raise InputError(
            f"pen {pen.name}: expected one pose_camera and one contact to read a D-POINT folder "
            "(its delay_s and pressure_threshold are needed)"
        )
    contact = contacts[0]
    read = read_dpoint(
        folder,
        cameras[0].delay_s,
        contact.pressure_threshold,
        height_m=contact.height_m,
        baseline_s=contact.pressure_baseline_s,
    )
    if read.scan is None:
        return WrittenRecording(read.recording)
    pressed = (read.pressure > contact.pressure_threshold).astype(float)
    return WrittenRecording(
        read.recording, Ink(ink_points_mm(read.scan), read.pressure_time_s, pressed)
    )


def read_dpoint(
    folder: str | Path,
    camera_delay_s: float,
    pressure_threshold: float,
    *,
    height_m: float = 0.0,
    baseline_s: float | None = None,
) -> DpointFolder:
    """Read a D-POINT folder.

    Parameters
    ----------
    camera_delay_s : time from a frame's capture to its host stamp, s
    pressure_threshold : pressure above which the tip touches the paper
    height_m : height of the paper, the reading of ``contact`` while it touches
    baseline_s : the threshold is above the baseline of so many seconds, see
        `recordings.pressure.above_baseline`; None takes the raw pressure

    Raises
    ------
    InputError
        If a file is missing, is not JSON, a row lacks a key, times do not
        increase, or an orientation is no rotation; the message names file and row.
    """
    folder = Path(folder)
    with reading(f"recording {folder}", "a D-POINT folder"):
        return _read(folder, camera_delay_s, pressure_threshold, height_m, baseline_s)


def _read(
    folder: Path,
    camera_delay_s: float,
    pressure_threshold: float,
    height_m: float,
    baseline_s: float | None,
) -> DpointFolder:
    stylus, camera = _load(folder / STYLUS_FILE), _load(folder / CAMERA_FILE)
    device_ms = _column(stylus, folder / STYLUS_FILE, "data", "t")
    host_ms = _column(stylus, folder / STYLUS_FILE, "t")
    accel = _column(stylus, folder / STYLUS_FILE, "data", "accel")
    gyro = _column(stylus, folder / STYLUS_FILE, "data", "gyro")
    pressure = _column(stylus, folder / STYLUS_FILE, "data", "pressure")
    frame_ms = _column(camera, folder / CAMERA_FILE, "t")
    position = _column(camera, folder / CAMERA_FILE, "data", "position")
    orientation = _column(camera, folder / CAMERA_FILE, "data", "orientation_mat")

    for key, values, shape in (
        ("t", host_ms, ()),
        ("data.t", device_ms, ()),
        ("data.accel", accel, (3,)),
        ("data.gyro", gyro, (3,)),
        ("data.pressure", pressure, ()),
        ("t", frame_ms, ()),
    ):
        if values.shape[1:] != shape:
            raise InputError(
                f"recording {folder}: {key} has shape {values.shape[1:]}, expected {shape}"
            )
    _check_increasing(device_ms, folder / STYLUS_FILE, "data.t")
    _check_increasing(frame_ms, folder / CAMERA_FILE, "t")
    offset_ms = np.median(host_ms - device_ms)
    start_ms = device_ms[0]
    time_s = (device_ms - start_ms) * 1e-3
    frame_s = (frame_ms - offset_ms - start_ms) * 1e-3 - camera_delay_s
    if position.shape[1:] != (3, 1) or orientation.shape[1:] != (3, 3):
        raise InputError(
            f"{folder / CAMERA_FILE}: position and orientation_mat have shapes "
            f"{position.shape[1:]} and {orientation.shape[1:]}, expected (3, 1) and (3, 3)"
        )
    _check_rotations(orientation, folder / CAMERA_FILE)
    pose = np.column_stack([position[:, :, 0], Rotation.from_matrix(orientation).as_rotvec()])
    pressing = pressure if baseline_s is None else above_baseline(time_s, pressure, baseline_s)
    touches = np.where(pressing > pressure_threshold, height_m, np.nan)
    recording = Recording.from_sensors(
        folder.name,
        {
            "accel": (time_s, accel),
            "gyro": (time_s, gyro),
            "camera": (frame_s, pose),
            "contact": (time_s, touches[:, None]),
        },
    )
    scan = folder / SCAN_FILE
    return DpointFolder(recording, time_s, pressing, scan if scan.is_file() else None)


def _load(path: Path) -> list[dict[str, Any]]:
    with open_regular(path, f"{path}", "a D-POINT file", "json_bytes") as file:
        rows = json_data(file.read(), f"{path}")
    if not isinstance(rows, list) or not rows:
        raise InputError(f"{path}: expected a list of samples, got none")
    check_most("rows", len(rows), f"{path}")
    return rows


def _column(rows: list[dict[str, Any]], path: Path, *keys: str) -> Array:
    values = []
    for number, row in enumerate(rows, 1):
        value: Any = row
        try:
            for key in keys:
                value = value[key]
            values.append(np.asarray(value, dtype=float))
        except (KeyError, TypeError, ValueError, OverflowError):
            raise InputError(f"{path}: row {number} has no number under {'.'.join(keys)}") from None
        if values[-1].shape != values[0].shape or not np.isfinite(values[-1]).all():
            raise InputError(
                f"{path}: row {number}: {'.'.join(keys)} is not finite or has another shape "
                f"than in row 1, expected {values[0].shape}"
            )
    return np.array(values)


def _check_increasing(time_ms: Array, path: Path, key: str) -> None:
    late = np.flatnonzero(np.diff(time_ms) <= 0)
    if len(late):
        row = late[0] + 1
        raise InputError(
            f"{path}: row {row + 1}: {key} ({time_ms[row]:.12g} ms) does not follow the one before "
            f"({time_ms[row - 1]:.12g} ms), expected increasing times"
        )


def _check_rotations(matrices: Array, path: Path) -> None:
    error = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    bad = np.flatnonzero((error > ROTATION_TOLERANCE) | (np.linalg.det(matrices) < 0))
    if len(bad):
        raise InputError(f"{path}: row {bad[0] + 1}: data.orientation_mat, expected a rotation")
