"""Commands that answer a question about a pen rather than estimate a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import typer

from benchmark.consistency_runs import CASES
from mhe.config import MheConfig
from pen_mhe import benchmark_run, consistency_run, dpoint_table, observe_run, printed_cost_run
from pen_mhe.console import one_sentence
from pen_mhe.options import (
    JobsOption,
    PenOption,
    SensorsOption,
    WritingAreaOption,
    names,
    rate_hz,
)

HORIZON = MheConfig().horizon


def benchmark(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = Path("results"),
    seeds: Annotated[int, typer.Option(help="Number of simulated recordings.", min=1)] = 5,
    jobs: JobsOption = 2,
) -> None:
    """Simulate a stroke and estimate it with every configuration and estimator."""
    with one_sentence():
        benchmark_run.run_benchmark(output, seeds, jobs)


def observe(
    pen: PenOption = "reference",
    sensors: SensorsOption = None,
    writing_area: WritingAreaOption = True,
    duration: Annotated[float, typer.Option(help="Of each motion, s.")] = 3.0,
) -> None:
    """Say what a choice of sensors can see, and what it cannot, in words of the state."""
    with one_sentence():
        observe_run.run_observe(pen, names(sensors), writing_area, duration)


def consistency(
    pen: PenOption = "dpoint",
    sensors: SensorsOption = "accel,gyro,camera",
    cases: Annotated[str, typer.Option(help="Names with commas.")] = ",".join(CASES),
    estimators: Annotated[str, typer.Option(help="Names with commas.")] = "ekf,mhe-ipopt",
    runs: Annotated[int, typer.Option(help="Of each case and estimator.", min=2)] = 50,
    jobs: JobsOption = 2,
) -> None:
    """Compare errors and innovations with the covariances that estimators claim (NEES, NIS)."""
    with one_sentence():
        consistency_run.run_consistency(
            pen, names(sensors), names(cases) or (), names(estimators) or (), runs, jobs
        )


def printed_cost(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = Path(
        "results/printed_cost"
    ),
) -> None:
    """Show what the pen model as printed in the paper costs, term by term, over speed."""
    with one_sentence():
        printed_cost_run.run_printed_cost(output)


def dpoint(
    recording: Annotated[Path, typer.Argument(help="The D-POINT folder.")],
    output: Annotated[Path, typer.Option(help="Folder for the cells, to resume from.")] = Path(
        "results/dpoint"
    ),
    pen: PenOption = "dpoint",
    rates: Annotated[str, typer.Option(help="Camera rates, Hz.")] = "30,10,3",
    estimators: Annotated[str, typer.Option(help="Names with commas.")] = "ekf,mhe-ipopt",
    horizon: Annotated[int, typer.Option(help="Intervals in the window of an MHE.")] = HORIZON,
    duration: Annotated[float | None, typer.Option(help="Use only the first seconds.")] = None,
    jobs: JobsOption = 2,
) -> None:
    """Mean ink distance over camera rates and all phases, zero delay."""
    with one_sentence():
        dpoint_table.run_table(
            recording,
            output,
            pen,
            [rate_hz(rate) for rate in rates.split(",")],
            names(estimators) or (),
            horizon,
            duration,
            jobs,
        )


COMMANDS: Mapping[str, Callable[..., None]] = {
    "benchmark": benchmark,
    "observe": observe,
    "consistency": consistency,
    "printed-cost": printed_cost,
    "dpoint-table": dpoint,
}
"""Name → function of every command here."""
