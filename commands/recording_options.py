"""Options of a command that reads a recording: what it is, and of which pen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from commands.options import PenOption, SensorsOption, WritingAreaOption


@dataclass(frozen=True, kw_only=True)
class RecordingOptions:
    """A recording and the pen that wrote it."""

    recording: Annotated[Path, typer.Argument(help="A D-POINT folder, or a .csv or .parquet file.")]
    pen: PenOption
    sensors: SensorsOption = None
    writing_area: WritingAreaOption = True
    units: Annotated[
        str | None,
        typer.Option(help="Units of a table's columns, e.g. accel=g,gyro=deg_s; SI by default."),
    ] = None
