"""``pen-mhe codegen``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from commands.command_line import command_line
from commands.lists import completing
from commands.options import PenOption, RestOption, SensorsOption, WritingAreaOption, names
from commands.sentences import one_sentence


def codegen(
    output: Annotated[Path, typer.Option(help="Folder for the C files.")],
    pen: PenOption = "reference",
    sensors: SensorsOption = None,
    writing_area: WritingAreaOption = True,
    rest: RestOption = True,
    estimator: Annotated[
        str | None,
        typer.Option(
            help="One of {exportable}; by default {default_export}.",
            autocompletion=completing("exportable"),
        ),
    ] = None,
    horizon: Annotated[
        int | None, typer.Option(help="Intervals in the window of an estimator that has one.")
    ] = None,
    deadline: Annotated[
        float | None, typer.Option(help="Of such an estimator: s per step, by a clock of yours.")
    ] = None,
    lag_samples: Annotated[
        list[int] | None,
        typer.Option(
            help="Of such an estimator: tell of so many samples ago too; several by more."
        ),
    ] = None,
    late_samples: Annotated[
        int | None,
        typer.Option(
            help="Of the ekf: measurements back that a late one is taken at least; "
            "0 takes none, and needs the least RAM."
        ),
    ] = None,
    float32: Annotated[
        bool, typer.Option("--float32", help="Single precision, with square roots of covariances.")
    ] = False,
    roots: Annotated[
        bool,
        typer.Option("--roots", help="Square roots in double too: much less code."),
    ] = False,
    watch: Annotated[
        bool,
        typer.Option("--watch", help="Say what is wrong with sensors, and leave out what lies."),
    ] = False,
    prefix: Annotated[str, typer.Option(help="Of the files' and the functions' names.")] = "pen",
) -> None:
    """Write an estimator of a pen as C99 without dynamic memory, for other machines."""
    from codegen.exportable import DEFAULT_EXPORT  # slow to import
    from commands.codegen_run import CodegenRequest, run_codegen

    with one_sentence():
        run_codegen(
            CodegenRequest(
                pen=pen,
                sensors=names(sensors),
                writing_area=writing_area,
                rest=rest,
                estimator=estimator or DEFAULT_EXPORT,
                horizon=horizon,
                deadline_s=deadline,
                lag_samples=tuple(lag_samples or ()),
                late_samples=late_samples,
                real="float" if float32 else "double",
                form="root" if roots else None,
                watch=watch,
                prefix=prefix,
                output=output,
                command=command_line(),
            )
        )
