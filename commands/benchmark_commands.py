"""The commands ``benchmark`` and ``report``: which sensors, and which estimator."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from commands.command_line import command_line
from commands.lists import complete_cases, completing, completing_several
from commands.options import JobsOption, names
from commands.sentences import one_sentence
from estimation.output_folder import RESULTS
from models.errors import InputError
from models.names import unknown
from suites.table import MODULES, NAMED, OF_OWN_PEN

DataOption = Annotated[
    Path | None, typer.Option(help="Folder with real recordings.", envvar="PEN_MHE_DATA")
]


def complete_suites(incomplete: str) -> list[str]:
    """Complete the name of a suite."""
    return [name for name in NAMED if name.startswith(incomplete)]


def benchmark(
    suites: Annotated[
        list[str] | None,
        typer.Argument(
            help="{suites} (default: all of these); {suites_by_name}.",
            autocompletion=complete_suites,
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option(help="Folder; an interrupted run continues there.")
    ] = RESULTS,
    seeds: Annotated[int, typer.Option(help="Simulated recordings of every case.", min=1)] = 5,
    jobs: JobsOption = 2,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a running Dask cluster, instead of processes.")
    ] = None,
    data: DataOption = None,
    estimators: Annotated[
        str | None,
        typer.Option(
            help="Names with commas: run only these, of {estimators} and the suites' own.",
            autocompletion=completing_several("estimators"),
        ),
    ] = None,
    cases: Annotated[
        str | None,
        typer.Option(
            help="Names with commas: run only these, of the suites' own. A name that holds a comma "
            "stands in double quotes.",
            autocompletion=complete_cases,
        ),
    ] = None,
    pen: Annotated[
        str | None,
        typer.Option(
            help="With one suite, of {own_pen}: ask of this pen. A pen file, or one of {pens}.",
            autocompletion=completing("pens"),
        ),
    ] = None,
    motion: Annotated[
        str | None,
        typer.Option(
            help="Of --pen, suite pen: what it is simulated along, of {motions}; handwriting by "
            "default.",
            autocompletion=completing("motions"),
        ),
    ] = None,
    recording: Annotated[
        Path | None,
        typer.Option(help="Of --pen, suite pen: a recording of it, instead of a motion."),
    ] = None,
) -> None:
    """Run the suites and write the report: which sensors, and which estimator."""
    with one_sentence():
        chosen = suites or list(MODULES)
        for suite in chosen:
            if suite not in NAMED:
                raise unknown("suite", suite, NAMED)
        if data is not None and not data.is_dir():
            raise InputError(f"data folder {data} does not exist, expected a folder of recordings")
        from benchmark.runner.run import Workers  # tables and figures are slow to import
        from benchmark.tasks.suite import Scope
        from commands import benchmark_run

        unique = list(dict.fromkeys(chosen))
        _check_own_pen(pen, motion, recording, unique)
        scope = Scope(
            seeds,
            None if data is None else str(data.resolve()),
            names(estimators),
            pen,
            motion or Scope.motion,
            None if recording is None else str(recording.resolve()),
            names(cases),
        )
        if pen is not None:
            unique = [OF_OWN_PEN[suite].suite for suite in unique]
        workers = Workers(jobs, scheduler)
        benchmark_run.run_benchmark(unique, output, scope, workers, command_line())


def _check_own_pen(
    pen: str | None, motion: str | None, recording: Path | None, suites: Sequence[str]
) -> None:
    """Raise `InputError` unless the options about a pen of one's own fit together."""
    beside = [
        name for name, value in (("motion", motion), ("recording", recording)) if value is not None
    ]
    if pen is None:
        if beside:
            raise InputError("--motion and --recording are of --pen, expected a pen beside them")
        return
    if len(suites) > 1 or suites[0] not in OF_OWN_PEN:
        asked, can = ", ".join(suites), " or ".join(OF_OWN_PEN)
        raise InputError(f"--pen with suites {asked}, expected suite {can} alone")
    for name in beside:
        if name not in OF_OWN_PEN[suites[0]].reads:
            raise InputError(f"--{name} is not read by suite {suites[0]}, expected --pen alone")
    if len(beside) > 1:
        raise InputError("--motion beside --recording, expected one of them")


def report(
    folder: Annotated[Path, typer.Argument(help="Of a finished `pen-mhe benchmark`.")],
    pictures: Annotated[
        Path | None, typer.Option(help="Folder for every figure as a PNG file too.")
    ] = None,
) -> None:
    """Draw the report of a run again from its files."""
    from commands import benchmark_run  # tables and figures are slow to import

    with one_sentence():
        benchmark_run.show_report(folder, pictures)
