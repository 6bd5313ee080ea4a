"""Commands that answer a question about a pen rather than estimate a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import typer

from benchmark.bad_start_cases import CASES as BAD_STARTS
from benchmark.bad_starts import ESTIMATORS as COMPARED
from benchmark.consistency_runs import CASES
from mhe.config import MheConfig
from models.errors import InputError
from pen_mhe import consistency_run, observe_run
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
    suites: Annotated[
        list[str] | None, typer.Argument(help="stroke (default) or speed, or both.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Folder for tables and figures; results or results/SUITE by default."),
    ] = None,
    seeds: Annotated[
        int, typer.Option(help="Of stroke: number of simulated recordings.", min=1)
    ] = 5,
    jobs: JobsOption = 2,
) -> None:
    """Simulate a stroke and estimate it with everything (stroke), or time the solvers (speed)."""
    with one_sentence():
        chosen = suites or ["stroke"]
        for suite in chosen:
            if suite not in SUITES:
                raise InputError(f"suite {suite} is unknown, expected one of {', '.join(SUITES)}")
        for suite in chosen:
            SUITES[suite](output, seeds, jobs)


def _stroke(output: Path | None, seeds: int, jobs: int) -> None:
    from pen_mhe import benchmark_run  # tables and figures are slow to import

    benchmark_run.run_benchmark(output or Path("results"), seeds, jobs)


def _speed(output: Path | None, seeds: int, jobs: int) -> None:
    from pen_mhe import speed_run  # tables and figures are slow to import

    folder = output or Path("results/speed")
    if speed_run.is_single_threaded():
        speed_run.run_speed(folder)
    elif status := speed_run.again_single_threaded(folder):
        raise typer.Exit(status)


SUITES: Mapping[str, Callable[[Path | None, int, int], None]] = {"stroke": _stroke, "speed": _speed}
"""Benchmark suite → function of folder, seeds and processes."""


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
    estimators: Annotated[str, typer.Option(help="Names with commas.")] = "ekf,mhe",
    runs: Annotated[int, typer.Option(help="Of each case and estimator.", min=2)] = 50,
    jobs: JobsOption = 2,
) -> None:
    """Compare errors and innovations with the covariances that estimators claim (NEES, NIS)."""
    with one_sentence():
        consistency_run.run_consistency(
            pen, names(sensors), names(cases) or (), names(estimators) or (), runs, jobs
        )


def bad_starts(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = Path(
        "results/bad_starts"
    ),
    cases: Annotated[str, typer.Option(help="Names with commas.")] = ",".join(BAD_STARTS),
    estimators: Annotated[str, typer.Option(help="Names with commas.")] = ",".join(COMPARED),
    runs: Annotated[int, typer.Option(help="Of each case and estimator.", min=1)] = 100,
    jobs: JobsOption = 2,
) -> None:
    """Start estimators at a wrong elevation and compare their first second."""
    from pen_mhe import bad_starts_run  # tables and figures are slow to import

    with one_sentence():
        bad_starts_run.run_bad_starts(
            output, names(cases) or (), names(estimators) or (), runs, jobs
        )


def printed_cost(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = Path(
        "results/printed_cost"
    ),
) -> None:
    """Show what the pen model as printed in the paper costs, term by term, over speed."""
    from pen_mhe import printed_cost_run  # tables and figures are slow to import

    with one_sentence():
        printed_cost_run.run_printed_cost(output)


def optimum(
    windows: Annotated[int, typer.Option(help="Number of windows.", min=1)] = 1000,
    seed: Annotated[int, typer.Option(help="Of the first window.", min=0)] = 0,
    output: Annotated[Path, typer.Option(help="Folder for the table.")] = Path("results/optimum"),
    jobs: JobsOption = 2,
) -> None:
    """Compare the real-time MHE's optimum with IPOPT's, window by window, from the same start."""
    from pen_mhe import optimum_run  # tables are slow to import

    with one_sentence():
        optimum_run.run_optimum(output, windows, jobs, seed)


def dpoint(
    recording: Annotated[Path, typer.Argument(help="The D-POINT folder.")],
    output: Annotated[Path, typer.Option(help="Folder for the cells, to resume from.")] = Path(
        "results/dpoint"
    ),
    pen: PenOption = "dpoint",
    rates: Annotated[str, typer.Option(help="Camera rates, Hz.")] = "30,10,3",
    estimators: Annotated[str, typer.Option(help="Names with commas.")] = "ekf,mhe",
    horizon: Annotated[int, typer.Option(help="Intervals in the window of an MHE.")] = HORIZON,
    duration: Annotated[float | None, typer.Option(help="Use only the first seconds.")] = None,
    jobs: JobsOption = 2,
) -> None:
    """Mean ink distance over camera rates and all phases, zero delay."""
    from pen_mhe import dpoint_table  # tables are slow to import

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
    "bad-starts": bad_starts,
    "printed-cost": printed_cost,
    "optimum": optimum,
    "dpoint-table": dpoint,
}
"""Name → function of every command here."""
