"""Commands that answer a question about a pen rather than estimate a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmark.runner.interrupts import not_swallowed
from commands.command_line import command_line
from commands.lists import LISTS, complete_sensors, completing, completing_several
from commands.options import JobsOption, PenOption, SensorsOption, WritingAreaOption, names
from commands.sentences import one_sentence
from models.errors import InputError
from models.names import unknown
from suites.table import MODULES, OWN_PEN

SPEED = "speed"
"""The suite that times solvers by itself, see `suites.speed.study`."""


DataOption = Annotated[
    Path | None, typer.Option(help="Folder with real recordings.", envvar="PEN_MHE_DATA")
]


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


def complete_suites(incomplete: str) -> list[str]:
    """Complete the name of a suite."""
    return [name for name in (*MODULES, SPEED) if name.startswith(incomplete)]


def benchmark(
    suites: Annotated[
        list[str] | None,
        typer.Argument(
            help=f"{{suites}} (default: all of these), or {SPEED} alone.",
            autocompletion=complete_suites,
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option(help="Folder; an interrupted run continues there.")
    ] = Path("results"),
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
    pen: Annotated[
        str | None,
        typer.Option(
            help="With suite pen alone: ask of this pen. A pen file, or one of {pens}.",
            autocompletion=completing("pens"),
        ),
    ] = None,
    motion: Annotated[
        str | None,
        typer.Option(
            help="Of --pen: what it is simulated along, of {motions}; handwriting by default.",
            autocompletion=completing("motions"),
        ),
    ] = None,
    recording: Annotated[
        Path | None, typer.Option(help="Of --pen: a recording of it, instead of a motion.")
    ] = None,
    problems: Annotated[
        str | None, typer.Option(help=f"Of {SPEED}: names with commas; by default all.")
    ] = None,
    windows: Annotated[
        int | None, typer.Option(help=f"Of {SPEED}: at most so many per problem.", min=1)
    ] = None,
) -> None:
    """Run the suites and write the report: which sensors, and which estimator."""
    with one_sentence():
        if suites == [SPEED]:
            if estimators is not None:
                raise InputError(f"--estimators is not of suite {SPEED}, expected other suites")
            _speed(output, names(problems), windows)
            return
        if problems is not None or windows is not None:
            raise InputError(f"--problems and --windows are of suite {SPEED}, expected it alone")
        chosen = suites or list(MODULES)
        for suite in chosen:
            if suite == SPEED:
                raise InputError(f"suite {SPEED} among others, expected it alone: it needs quiet")
            if suite not in MODULES:
                raise unknown("suite", suite, (*MODULES, SPEED))
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
        )
        if pen is not None:
            unique = [OWN_PEN]
        workers = Workers(jobs, scheduler)
        benchmark_run.run_benchmark(unique, output, scope, workers, command_line())


def _check_own_pen(
    pen: str | None, motion: str | None, recording: Path | None, suites: Sequence[str]
) -> None:
    """Raise `InputError` unless the options about a pen of one's own fit together."""
    if pen is None and (motion is not None or recording is not None):
        raise InputError("--motion and --recording are of --pen, expected a pen beside them")
    if pen is not None and list(suites) != ["pen"]:
        raise InputError(f"--pen with suites {', '.join(suites)}, expected suite pen alone")
    if motion is not None and recording is not None:
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


def _speed(output: Path, keys: Sequence[str] | None, windows: int | None) -> None:
    from suites.speed import problems, study  # tables and figures are slow to import

    given: dict[str, Any] = {} if windows is None else {"windows": windows}
    if keys is not None:
        given["problems"] = [problems.find_problem(key) for key in keys]
    study.run_speed(output, **given)


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
    output: Annotated[Path, typer.Option(help="Folder that keeps what is finished.")] = Path(
        "results/consistency"
    ),
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
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = Path(
        "results/bad_starts"
    ),
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
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = Path(
        "results/printed_cost"
    ),
) -> None:
    """Show what the pen model as printed in the paper costs, term by term, over speed."""
    from suites.printed_cost import study  # tables and figures are slow to import

    with one_sentence():
        study.run_printed_cost(output)


def optimum(
    windows: Annotated[int, typer.Option(help="Number of windows.", min=1)] = 1000,
    seed: Annotated[int, typer.Option(help="Of the first window.", min=0)] = 0,
    output: Annotated[Path, typer.Option(help="Folder for the table.")] = Path("results/optimum"),
    jobs: JobsOption = 2,
) -> None:
    """Compare the real-time MHE's optimum with IPOPT's, window by window, from the same start."""
    from suites.optimum import study  # tables are slow to import

    with one_sentence():
        study.run_optimum(output, windows, jobs, seed)


def real_time(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = Path(
        "results/real_time"
    ),
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
    "consistency": consistency,
    "bad-starts": bad_starts,
    "printed-cost": printed_cost,
    "optimum": optimum,
    "real-time": real_time,
}
"""Name → function of every command here."""
