"""The work behind ``pen-mhe benchmark`` and ``pen-mhe report``."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from benchmark.console import console, print_markdown
from benchmark.figures.figure import Figure
from benchmark.figures.matplotlib_figure import matplotlib_figure
from benchmark.figures.style import colours_of
from benchmark.report.content import content
from benchmark.report.report import PAGE, TEXT, write_content
from benchmark.report.terminal import PRINTED, terminal
from benchmark.runner.about import NAME as ABOUT
from benchmark.runner.about import about, read_about, session, write_about
from benchmark.runner.interrupts import interrupted
from benchmark.runner.outcome_lines import NAME as JOURNAL
from benchmark.runner.run import Workers
from benchmark.runner.tables import RESULTS, SERIES, read_tables
from benchmark.tasks.suite import Scope
from estimation.apart import check_apart
from estimation.output_folder import check_folder, make_folder
from estimation.progress_bar import progress
from models.errors import InputError
from models.pen_file import pen_paths
from suites.execute import chosen_tasks, run_suites
from suites.table import find_suite

RUN = (RESULTS, SERIES, ABOUT)
REPORT = (PAGE, TEXT)
"""Files of a run, and of its report."""


def run_benchmark(
    suites: Sequence[str], output: Path, scope: Scope, workers: Workers, command: str
) -> None:
    """Run the tasks that are not finished, write tables and report, print the matrix.

    Parameters
    ----------
    suites : names
    output : folder; an interrupted run continues there
    command : to repeat the run with, for the report
    """
    check_folder(output)
    check_apart([output / name for name in (*RUN, *REPORT, JOURNAL)], _read_files(scope))
    for name in suites:
        if line := find_suite(name).missing(scope):
            console.print(line)
    tasks = chosen_tasks(suites, scope)
    if not tasks:
        raise InputError(f"suites {', '.join(suites)} have no tasks, expected some")
    run = about(command, list(suites), scope.seeds)
    for name in suites:
        run |= find_suite(name).own(scope)
    for field in ("estimators", "cases"):
        if (asked := getattr(scope, field)) is not None:
            run[field] = list(asked)
    run["sessions"] = _earlier_sessions(output, run["code"])
    started, clock = datetime.now(UTC), time.perf_counter()
    done, finished = 0, False

    def on_start(total: int) -> Any:
        if total < len(tasks):
            console.print(f"{len(tasks) - total} of {len(tasks)} tasks are finished already")
        advance = start(total)
        _sat(run, output, session(started, 0.0, str(workers), 0, False))

        def counted(tasks_done: int) -> None:
            nonlocal done
            done += tasks_done
            advance(tasks_done)

        return counted

    try:
        with progress("benchmark") as start:
            run_suites(tasks, scope, workers, output, on_start)
        finished = True
    except KeyboardInterrupt:
        raise interrupted(done) from None
    finally:
        if done or finished:  # else the folder is what it was: perhaps another run's
            seconds = time.perf_counter() - clock
            _sat(run, output, session(started, seconds, str(workers), done, finished))
    show_report(output)


def _read_files(scope: Scope) -> dict[str, list[Path | None]]:
    """Return what a run reads of files that a person named."""
    recording = None if scope.recording is None else Path(scope.recording)
    pens = [] if scope.pen is None else list(pen_paths(scope.pen))
    return {"the recording": [recording], "the pen file": [*pens]}


def _sat(run: Mapping[str, Any], output: Path, sitting: Mapping[str, Any]) -> None:
    """Write ``run.json`` with one more sitting than before this run."""
    write_about({**run, "sessions": [*run["sessions"], sitting]}, output)


def show_report(folder: Path, pictures: Path | None = None) -> None:
    """Write the report of a finished run, print its matrices, its answer and its path.

    Parameters
    ----------
    pictures : folder for every figure as a PNG file; None draws none
    """
    read = [folder / name for name in RUN]
    check_apart([folder / name for name in REPORT], {"what a report is drawn from": read})
    if pictures is not None:
        check_folder(pictures)
    results, run = read_tables(folder), read_about(folder)
    names = [name for name in run.get("suites", []) if name in set(results.rows["suite"])]
    suites = [find_suite(name) for name in names]
    found = content(results, suites, run)
    page = write_content(found, folder)
    print_markdown(terminal(found, PRINTED))
    if pictures is not None:
        _draw_pictures([figure for part in found.parts for figure in part.figures], pictures)
    console.print(f"\nreport: {page}")


def _draw_pictures(figures: Sequence[Figure], folder: Path) -> None:
    from pen_mhe.figures import save  # slow to import

    make_folder(folder)
    colours = colours_of(figures)
    for figure in figures:
        save(matplotlib_figure(figure, colours), folder / f"{figure.key}.png")


def _earlier_sessions(output: Path, code: str) -> list[dict[str, Any]]:
    """Return the sittings of a run that is continued with the same code."""
    try:
        earlier = read_about(output)
    except InputError:
        return []
    return list(earlier.get("sessions", [])) if earlier.get("code") == code else []
