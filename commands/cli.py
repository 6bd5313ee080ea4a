"""The command ``pen-mhe``."""

from __future__ import annotations

import os
import platform
import warnings
from importlib import metadata
from typing import Annotated

import typer

from commands import benchmark_commands, calibrate, check, codegen, observe, simulate
from commands.group import App, Commands
from commands.help_page import Command
from commands.sentences import one_line_warning
from models.version import version

app = App(
    cls=Commands,
    no_args_is_help=True,
    rich_markup_mode=None,  # boxes leave words no room at 80 columns
    pretty_exceptions_show_locals=False,
)


def _print_version(asked: bool) -> None:
    if asked:
        print(
            f"pen-mhe {version()}, Python {platform.python_version()}, "
            f"casadi {metadata.version('casadi')}"
        )
        raise typer.Exit


@app.callback()
def main(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_version,
            is_eager=True,
            help="Print the versions of pen-mhe, Python and casadi.",
        ),
    ] = False,
) -> None:
    """Which motion sensors does a pen need, and does optimisation pay off over a Kalman filter?"""
    warnings.showwarning = one_line_warning
    os.environ.setdefault("MPLBACKEND", "Agg")  # figures are written, not shown


app.command(cls=Command)(simulate.simulate)
app.command(cls=Command)(check.check)
app.command(cls=Command)(benchmark_commands.benchmark)
app.command(cls=Command)(benchmark_commands.report)
app.command(cls=Command)(observe.observe)
app.command(cls=Command)(codegen.codegen)
app.add_typer(calibrate.app, name="calibrate")


if __name__ == "__main__":
    app(prog_name="pen-mhe")
