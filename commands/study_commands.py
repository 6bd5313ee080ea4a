"""Commands that answer a question about a pen rather than estimate a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import typer

from benchmark.runner.interrupts import not_swallowed
from commands.benchmark_commands import DataOption, benchmark, report
from commands.options import JobsOption, PenOption, SensorsOption, WritingAreaOption, names
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


def printed_cost(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = RESULTS
    / "printed_cost",
) -> None:
    """Show what the pen model as printed in the paper costs, term by term, over speed."""
    from suites.printed_cost import study  # tables and figures are slow to import

    with one_sentence():
        study.run_printed_cost(output)


def optimum(
    windows: Annotated[int, typer.Option(help="Number of windows.", min=1)] = 1000,
    seed: Annotated[int, typer.Option(help="Of the first window.", min=0)] = 0,
    output: Annotated[Path, typer.Option(help="Folder for the table.")] = RESULTS / "optimum",
    jobs: JobsOption = 2,
) -> None:
    """Compare the real-time MHE's optimum with IPOPT's, window by window, from the same start."""
    from suites.optimum import study  # tables are slow to import

    with one_sentence():
        study.run_optimum(output, windows, jobs, seed)


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
    "printed-cost": printed_cost,
    "optimum": optimum,
    "real-time": real_time,
}
"""Name → function of every command here."""
