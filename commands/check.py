"""``pen-mhe check``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from commands.lists import completing
from commands.option_groups import fields_group, grouped
from commands.options import units as read_units
from commands.recording_options import FileOptions
from commands.sentences import ExitCode, one_sentence


@dataclass(frozen=True, kw_only=True)
class Checked(FileOptions):
    """A recording, and the pen that it is compared with."""

    pen: Annotated[
        str | None,
        typer.Option(
            help="Pen file, or a bundled pen: {pens}. Without one mounting and noise are not "
            "compared, and sensors are called as the reference pen's.",
            autocompletion=completing("pens"),
        ),
    ] = None


@grouped(source=fields_group(Checked))
def check(
    source: Checked,
    table: Annotated[Path | None, typer.Option(help="Table to write, .csv or .parquet.")] = None,
) -> None:
    """Check a recording: say what is wrong with it, and what to do.

    Asks of rates, gaps, stamps, units, stuck and clipped sensors, gravity, signs
    and axes, mounting, noise and lag. Each finding says what, where, how sure
    and what to do. Ends with 1 where an estimate could not be meant.
    """
    with one_sentence():
        from recordings.checked import check as checked_recording  # tables are slow to import

        found = checked_recording(
            source.recording,
            source.pen,
            units=read_units(source.units),
            columns=source.columns,
            strict=source.strict,
        )
        if table is not None:
            from recordings.formats.tables import check_output, write_table

            check_output(table)
            write_table(found.table, table)
        from benchmark.console import console

        console.print(found.text)
    if not found.is_meant:
        raise typer.Exit(ExitCode.NOT_MEANT)
