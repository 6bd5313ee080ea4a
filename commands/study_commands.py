"""Commands that answer a question about a pen rather than estimate a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import typer

from benchmark.runner.interrupts import not_swallowed
from commands.benchmark_commands import benchmark, report
from commands.lists import LISTS, complete_sensors, completing_several
from commands.options import JobsOption, PenOption, SensorsOption, WritingAreaOption, names
from commands.sentences import one_sentence
from estimation.output_folder import RESULTS

EstimatorsOption = Annotated[
    str,
    typer.Option(
        help="Names with commas, of {estimators}.",
        autocompletion=completing_several("estimators"),
    ),
]


def all_or(text: str | None, key: str) -> tuple[str, ...]:
    """Return the names in a text with commas; without one, all of a list of `LISTS`."""
    return names(text) or tuple(LISTS[key]())


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


def consistency(
    output: Annotated[Path, typer.Option(help="Folder that keeps what is finished.")] = RESULTS
    / "consistency",
    pen: PenOption = "dpoint",
    sensors: Annotated[
        str,
        typer.Option(help="Names from the pen file, with commas.", autocompletion=complete_sensors),
    ] = "accel,gyro,camera",
    cases: Annotated[
        str | None,
        typer.Option(
            help="Names with commas, of {consistency_cases}; by default all.",
            autocompletion=completing_several("consistency_cases"),
        ),
    ] = None,
    estimators: EstimatorsOption = "ekf,mhe",
    runs: Annotated[int, typer.Option(help="Of each case and estimator.", min=2)] = 50,
    jobs: JobsOption = 2,
) -> None:
    """Compare errors and innovations with the covariances that estimators claim (NEES, NIS)."""
    from suites.consistency import study

    with one_sentence():
        study.run_consistency(
            output,
            pen,
            names(sensors),
            all_or(cases, "consistency_cases"),
            names(estimators) or (),
            runs,
            jobs,
        )


def bad_starts(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = RESULTS
    / "bad_starts",
    cases: Annotated[
        str | None,
        typer.Option(
            help="Names with commas, of {bad_starts}; by default all.",
            autocompletion=completing_several("bad_starts"),
        ),
    ] = None,
    estimators: Annotated[
        str | None,
        typer.Option(
            help="Names with commas, of {estimators}; by default {compared}.",
            autocompletion=completing_several("estimators"),
        ),
    ] = None,
    runs: Annotated[int, typer.Option(help="Of each case and estimator.", min=1)] = 100,
    jobs: JobsOption = 2,
) -> None:
    """Start estimators at a wrong elevation and compare their first second."""
    from suites.bad_starts import study  # tables and figures are slow to import

    with one_sentence():
        study.run_bad_starts(
            output, all_or(cases, "bad_starts"), all_or(estimators, "compared"), runs, jobs
        )


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


COMMANDS: Mapping[str, Callable[..., None]] = {
    "benchmark": benchmark,
    "report": report,
    "observe": observe,
    "consistency": consistency,
    "bad-starts": bad_starts,
    "printed-cost": printed_cost,
    "optimum": optimum,
}
"""Name → function of every command here."""
