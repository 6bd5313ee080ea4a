"""Commands that answer a question about a pen rather than estimate a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import typer

from benchmark.runner.interrupts import not_swallowed
from commands.benchmark_commands import DataOption, benchmark, report
from commands.options import PenOption, SensorsOption, WritingAreaOption, names
from commands.sentences import one_sentence
from estimation.output_folder import RESULTS
from models.errors import InputError


def observe(
    pen: PenOption = "reference",
    sensors: SensorsOption = None,
    writing_area: WritingAreaOption = True,
    duration: Annotated[float, typer.Option(help="Of each motion, s.")] = 3.0,
) -> None:
    """Say what a choice of sensors can see, and what it cannot, in words of the state."""
    with one_sentence(), not_swallowed():
        from commands import observe_run  # models are slow to import

        observe_run.run_observe(pen, names(sensors), writing_area, duration)


def real_time(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = RESULTS
    / "real_time",
    data: DataOption = None,
    steps: Annotated[int, typer.Option(help="By the clock, per estimator.", min=1)] = 100_000,
) -> None:
    """Measure a step of the real-time MHE: kept factors, deadlines, time per real sample."""
    from suites.real_time.study import run_real_time  # tables and figures are slow to import

    with one_sentence():
        if data is not None and not data.is_dir():
            raise InputError(f"data folder {data} does not exist, expected a folder of recordings")
        run_real_time(output, data, steps)


COMMANDS: Mapping[str, Callable[..., None]] = {
    "benchmark": benchmark,
    "report": report,
    "observe": observe,
    "real-time": real_time,
}
"""Name → function of every command here."""
