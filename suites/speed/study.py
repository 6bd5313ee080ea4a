"""The work behind ``pen-mhe benchmark speed``: rows, problem files, figures, verdicts."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

from benchmark.console import console, print_table, progress
from benchmark.report.numbers import in_unit
from estimation.output_folder import prepare_folder
from pen_mhe.figures import save
from suites.speed.export import write_problem
from suites.speed.figures import contender_figure, horizon_figure
from suites.speed.problems import PROBLEMS, Problem, find_problem
from suites.speed.rows import Row, write_rows
from suites.speed.suite import StreamPlan, few, race_filters, race_reuse, race_windows
from suites.speed.verdicts import Promise, PromiseVerdict, verdicts

SINGLE_THREADED: Mapping[str, str] = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""Environment under which NumPy, SciPy and CasADi's solvers start no threads."""

STREAM_PROBLEM = "pen15_20"
"""On whose recording the filters run."""
REUSE_PROBLEM = "pen24_60"
"""On whose recording factors are kept: its sensors hold all states, so they are by default."""
JUDGED = {True: "met", False: "missed", None: "no figure"}


def is_single_threaded() -> bool:
    """Return whether the environment had been set when NumPy was imported."""
    return all(os.environ.get(name) == value for name, value in SINGLE_THREADED.items())


def again_single_threaded(*words: str) -> int:
    """Run a command of pen-mhe in a process that starts no threads; return its exit status."""
    command = [sys.executable, "-m", "commands.cli", *words]
    return subprocess.run(command, env={**os.environ, **SINGLE_THREADED}, check=False).returncode


def run_speed(
    output: Path,
    problems: Sequence[Problem] = PROBLEMS,
    windows: int | None = None,
    stream: StreamPlan | None = None,
) -> list[Row]:
    """Race all contenders, write ``speed.json``, ``problem_*.npz`` and figures, print verdicts.

    Parameters
    ----------
    output : folder to write to
    windows : at most so many per problem; all where it is None
    stream : how much of it; `StreamPlan`'s own where it is None
    """
    prepare_folder(output)
    rows: list[Row] = []
    left_out: dict[str, str] = {}
    for problem in problems:
        limited = problem if windows is None else few(problem, windows)
        raced = race_windows(limited, left_out.setdefault, progress)
        rows += raced.rows
        write_problem(limited, raced.windows, output)
    plan = stream or StreamPlan()
    for race, streamed in ((race_filters, STREAM_PROBLEM), (race_reuse, REUSE_PROBLEM)):
        rows += race(find_problem(streamed), plan, left_out.setdefault, progress)
    write_rows(rows, output / "speed.json")
    save(contender_figure(rows), output / "speed.png")
    save(horizon_figure(rows), output / "speed_horizon.png")
    for name, reason in left_out.items():
        console.print(f"left out: {name}: {reason}")
    _print_rows(rows)
    _print_verdicts(verdicts(rows))
    console.print(
        f"\nPython {platform.python_version()}, {platform.machine()}, one thread, "
        f"pen-mhe {version('pen-mhe')}; speed.json, problems and figures in {output}"
    )
    return rows


def _print_rows(rows: Sequence[Row]) -> None:
    times, qualities = ["median", "p99"], ["cost", "error/std", "violation/std", "solved"]
    columns = ["problem", "N", "active", "contender", "mode", *times, *qualities, "build"]
    texts = [
        [
            row.problem,
            str(row.horizon),
            "" if row.active_rows is None else f"{row.active_rows:.1f}",
            row.contender,
            row.mode,
            in_unit(row.median_s),
            in_unit(row.p99_s),
            "" if row.cost is None else f"{row.cost:.10g}",
            "" if row.newest_error_std is None else f"{row.newest_error_std:.1e}",
            "" if row.violation_std is None else f"{row.violation_std:.1e}",
            f"{row.solved:.0%}",
            in_unit(row.build_s),
        ]
        for row in rows
    ]
    print_table("Time per window or sample", columns, texts)


def _print_verdicts(found: Sequence[PromiseVerdict]) -> None:
    texts = [
        [v.promise.text, _figure(v.promise, v.figure), _target(v.promise), JUDGED[v.kept]]
        for v in found
    ]
    print_table("\nWhat was promised", ["", "figure", "target", ""], texts)


def _figure(promise: Promise, figure: float | None) -> str:
    if figure is None:
        return ""
    return in_unit(figure) if promise.to is None else f"{figure:.3g}"


def _target(promise: Promise) -> str:
    if promise.to is None:
        return f"≤ {in_unit(promise.most)}"
    if promise.most == float("inf"):
        return f"≥ {promise.least:g}"
    if promise.least == 0:
        return f"≤ {promise.most:.3g}"
    return f"{promise.least:g} to {promise.most:g}"
