"""A recording with the ink that it left on paper."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from estimation.recording import Recording
from models.errors import InputError
from models.pen import PenConfig
from recordings.formats.dpoint import read_dpoint
from recordings.ink import Ink, ink_points_mm


@dataclass(frozen=True, eq=False)
class WrittenRecording:
    """A recording with the ink it left, where there is a scan."""

    recording: Recording
    ink: Ink | None = None


def load_dpoint(folder: Path, pen: PenConfig) -> WrittenRecording:
    """Read a D-POINT folder with the camera delay and pressure threshold of a pen."""
    cameras: list[Any] = [s for s in pen.sensors.values() if s.sees_pose]
    contacts: list[Any] = [s for s in pen.sensors.values() if s.reads_touch]
    if len(cameras) != 1 or len(contacts) != 1:
        raise InputError(
            f"pen {pen.name}: expected one pose_camera and one contact to read a D-POINT folder "
            "(its delay_s and pressure_threshold are needed)"
        )
    read = read_dpoint(
        folder, cameras[0].delay_s, contacts[0].pressure_threshold, contacts[0].height_m
    )
    if read.scan is None:
        return WrittenRecording(read.recording)
    pressed = (read.pressure > contacts[0].pressure_threshold).astype(float)
    return WrittenRecording(
        read.recording, Ink(ink_points_mm(read.scan), read.pressure_time_s, pressed)
    )
