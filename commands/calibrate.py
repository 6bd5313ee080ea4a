"""``pen-mhe calibrate``: a command for each kind of recording that tells about sensors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchmark.runner.interrupts import not_swallowed
from commands.group import Siblings
from commands.help_page import Command
from commands.lists import completing
from commands.options import PenOption, SensorsOption, names
from commands.options import units as read_units
from commands.sentences import one_sentence

app = typer.Typer(cls=Siblings, no_args_is_help=True, rich_markup_mode=None)


@app.callback()
def calibrate() -> None:
    """Find what a pen's sensors are worth from recordings made for that."""


@app.command(cls=Command)
def still(
    recordings: Annotated[
        list[Path],
        typer.Argument(
            help="D-POINT folders, .csv or .parquet files: one with all poses, or several.",
        ),
    ],
    output: Annotated[Path, typer.Option(help="Pen file to write, .toml.")],
    pen: PenOption,
    sensors: SensorsOption = None,
    find: Annotated[
        str,
        typer.Option(
            help="The most that is looked for, of {finds}, each with those before it.",
            autocompletion=completing("finds"),
        ),
    ] = "misalignment",
    units: Annotated[
        str | None,
        typer.Option(help="Units of a table's columns, e.g. accel=g,gyro=deg_s; SI by default."),
    ] = None,
) -> None:
    """Find biases, scales, misalignment and noise from a pen held still in poses.

    Still stretches are found in the recordings. Ten poses or more on all sides
    are needed for everything, a single one for gyroscopes and for noise.
    Writes the pen file anew, with what was found and how sure it is.
    """
    with one_sentence(), not_swallowed():
        from commands import calibrate_run  # models and tables are slow to import

        calibrate_run.run_still(recordings, output, pen, names(sensors), find, read_units(units))


@app.command(cls=Command)
def magnetometer(
    recordings: Annotated[
        list[Path],
        typer.Argument(help="Files of a pen that is turned about, one or several."),
    ],
    output: Annotated[Path, typer.Option(help="Pen file to write, .toml.")],
    pen: PenOption,
    sensors: SensorsOption = None,
    units: Annotated[
        str | None,
        typer.Option(help="Units of a table's columns, e.g. mag=gauss,accel=g; SI by default."),
    ] = None,
) -> None:
    """Find hard iron, soft iron and noise of a magnetometer from a pen turned about.

    Turn the pen slowly about all its axes, tip up and down, for half a minute,
    far from iron. Writes the pen file anew, with what was found and how sure it
    is.
    """
    with one_sentence(), not_swallowed():
        from commands import calibrate_run  # models and tables are slow to import

        calibrate_run.run_magnetometer(recordings, output, pen, names(sensors), read_units(units))


@app.command(cls=Command)
def camera(
    recording: Annotated[
        Path, typer.Argument(help="A D-POINT folder, or a .csv or .parquet file.")
    ],
    output: Annotated[Path, typer.Option(help="Pen file to write, .toml.")],
    pen: PenOption,
    sensors: SensorsOption = None,
    units: Annotated[
        str | None,
        typer.Option(help="Units of a table's columns, e.g. accel=g,gyro=deg_s; SI by default."),
    ] = None,
) -> None:
    """Find delay, turn, lever arm, level and slope from a pen in use before a camera.

    Judges by how well each frame is predicted from what was before it, with
    frames left out down to 10, 5 and 3 Hz; ink and truth take no part. Writes
    the pen file anew, with what was found and how sure it is.
    """
    with one_sentence(), not_swallowed():
        from commands import calibrate_run  # models and tables are slow to import

        calibrate_run.run_camera(recording, output, pen, names(sensors), read_units(units))
