"""Options of a command that reads a recording: what it is, and of which pen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from commands.options import PenOption, SensorsOption, WritingAreaOption


@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """A recording in files, and what is said of them."""

    recording: Annotated[
        list[Path],
        typer.Argument(
            help="A table (.csv, .txt, .parquet, .xlsx), several of one recording, a folder or "
            ".zip of them, a ROS bag, or a D-POINT folder."
        ),
    ]
    units: Annotated[
        str | None,
        typer.Option(
            help="Units of a table's columns where its headers have none, e.g. "
            "accel=g,gyro=deg_s,time=ms; counts: accel=g/16384."
        ),
    ] = None
    columns: Annotated[
        str | None,
        typer.Option(
            help="Which columns are which sensor's, e.g. 'accel=ax,ay,-az;time=millis', a minus "
            "turns a sign; or the names of all of a file without a header."
        ),
    ] = None
    strict: Annotated[
        bool, typer.Option("--strict", help="Refuse a file that would have to be repaired.")
    ] = False


@dataclass(frozen=True, kw_only=True)
class RecordingOptions(FileOptions):
    """A recording and the pen that wrote it."""

    pen: PenOption
    sensors: SensorsOption = None
    writing_area: WritingAreaOption = True
