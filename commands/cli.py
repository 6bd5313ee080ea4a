"""The command ``pen-mhe``."""

from __future__ import annotations

import warnings

import typer

from commands import estimate, simulate, study_commands
from commands.sentences import one_line_warning

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_show_locals=False,
)


@app.callback()
def main() -> None:
    """Which motion sensors does a pen need, and does optimisation pay off over a Kalman filter?"""
    warnings.showwarning = one_line_warning


app.command()(estimate.estimate)
app.command()(simulate.simulate)
for name, command in study_commands.COMMANDS.items():
    app.command(name)(command)


if __name__ == "__main__":
    app()
