"""Which pen a recording is estimated with where nobody names one.

A recording of this project's simulator has the truth of every state: it is of the reference pen,
as the simulator's is where nobody says another. A format may be of one bundled pen. Any other's
pen is found in what it shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from estimation.recording import Recording
from models.errors import InputError
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen, load_pen
from pen_mhe.no_pen.any_pen import any_pen
from pen_mhe.no_pen.axis import AnyAxis
from pen_mhe.no_pen.found_pen import FoundPen
from pen_mhe.no_pen.pen_for import pen_for
from recordings.asked import ColumnsAsked
from recordings.formats.table import format_of
from recordings.read import RecordingPath, in_parts, read_written
from recordings.unfit import UnfitTableError
from recordings.written import WrittenRecording

SIMULATED = "reference"
"""Bundled pen of a recording that was simulated, where nobody says another."""
TRUE_STATES = frozenset({"mrp_x", "mrp_y", "mrp_z"})
"""A truth that has these was simulated: nobody measures them."""


def pen_and_recording(
    recording: Recording | WrittenRecording | RecordingPath,
    pen: AnyPen | None,
    *,
    axis: AnyAxis | None = None,
    **asked: Any,
) -> tuple[PenConfig, WrittenRecording]:
    """Return a pen that was given, or is found, and the recording as it is read with it.

    Parameters
    ----------
    asked : units, columns, strict, see `recordings.read.read_written`

    Raises
    ------
    InputError
        If the recording is none, shows no pen, or an axis is given beside a pen.
    """
    if not isinstance(recording, Recording | WrittenRecording | str | Path | Sequence):
        raise InputError(
            f"recording is of type {type(recording).__name__}, expected a recording or its path"
        )
    if pen is not None:
        check_no_axis(axis)
        config, note, loaded = as_pen(pen), None, None
    else:
        which = pen_of(recording, axis, **asked)
        config, note, loaded = which.pen, which.note, which.loaded
    if loaded is None:
        loaded = _read(recording, config, **asked)
    return config, loaded if note is None else replace(loaded, notes=(note, *loaded.notes))


def check_no_axis(axis: AnyAxis | None) -> None:
    """Refuse an axis beside a pen.

    Raises
    ------
    InputError
        If there is one.
    """
    if axis is not None:
        raise InputError(
            f"axis {axis} is given with a pen, expected one of both: a pen says sensor_to_body"
        )


def _read(
    recording: Recording | WrittenRecording | RecordingPath, pen: PenConfig, **asked: Any
) -> WrittenRecording:
    if isinstance(recording, Recording):
        return WrittenRecording(recording)
    if isinstance(recording, WrittenRecording):
        return recording
    return read_written(recording, pen, **asked)


@dataclass(frozen=True, eq=False)
class WhichPen:
    """The pen of a recording of which nobody named it.

    Parameters
    ----------
    note : a sentence on why
    loaded : the recording, where it was read
    found : where the pen is found in it
    """

    pen: PenConfig
    note: str
    loaded: WrittenRecording | None = None
    found: FoundPen | None = None


def pen_of(
    recording: Recording | WrittenRecording | RecordingPath,
    axis: AnyAxis | None = None,
    *,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
    strict: bool = False,
) -> WhichPen:
    """Return the pen that a recording is estimated with.

    Parameters
    ----------
    axis, units, columns, strict : see `pen_mhe.no_pen.pen_for.pen_for`; with an axis the pen is
        found in the recording, whatever it is

    Raises
    ------
    InputError
        If the recording is none, or shows no pen.
    """
    if isinstance(recording, Recording):
        recording = WrittenRecording(recording)
    known = _known(recording, units, columns) if axis is None else None
    if known is not None:
        return known
    if not isinstance(recording, WrittenRecording):
        recording = read_written(recording, any_pen(), units=units, columns=columns, strict=strict)
    recording = recording.checked(recording.recording, any_pen(), against_pen=False)
    found = pen_for(recording, axis)
    loaded = replace(
        recording,
        notes=(*recording.notes, *found.notes),
        findings=(*recording.findings, *found.findings),
    )
    return WhichPen(found.pen, "no pen file: the pen is what the recording shows", loaded, found)


def _known(
    recording: WrittenRecording | RecordingPath,
    units: Mapping[str, str] | None,
    columns: ColumnsAsked | None,
) -> WhichPen | None:
    """Return a bundled pen that a recording is of; None where it may be of any."""
    if isinstance(recording, WrittenRecording):
        truth = recording.recording.truth
        names = () if truth is None else truth.names
        return _simulated(names, set(recording.recording.readings))
    paths = [recording] if isinstance(recording, str | Path) else list(recording)
    if len(paths) == 1 and Path(paths[0]).exists():
        row = format_of(Path(paths[0]))
        if row is not None and row.pen is not None:
            note = f"no pen file: {row.name} is of the bundled pen {row.pen}"
            return WhichPen(load_pen(row.pen), note)
    try:
        stream = in_parts(recording, load_pen(SIMULATED), units=units, columns=columns)
        if stream is None:
            return None
        with stream as opened:
            return _simulated(opened.header.truth_names, set(opened.header.sensors))
    except (UnfitTableError, InputError):
        return None


def _simulated(names: tuple[str, ...], sensors: set[str]) -> WhichPen | None:
    pen = load_pen(SIMULATED)
    if not set(names) >= TRUE_STATES or not sensors <= set(pen.sensors):
        return None
    note = f"no pen file: a simulated recording, taken for one of the bundled pen {SIMULATED}"
    return WhichPen(pen, note)
