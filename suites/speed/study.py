"""The work behind ``pen-mhe benchmark speed``: rows, problem files, figures, verdicts."""

from __future__ import annotations

import platform
import warnings
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from benchmark.console import console, print_table
from benchmark.report.numbers import in_unit
from benchmark.runner.about import timing_identity
from benchmark.runner.kept import Jobs, kept_results
from estimation.output_folder import check_folder
from pen_mhe.figures import save
from suites.speed.export import write_problem
from suites.speed.figures import contender_figure, horizon_figure
from suites.speed.parts import Part, WindowRace, parts_of, race_part
from suites.speed.problems import PROBLEMS, Problem
from suites.speed.rows import Row, write_rows
from suites.speed.suite import StreamPlan
from suites.speed.verdicts import Promise, PromiseVerdict, verdicts

JUDGED = {True: "met", False: "missed"}


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
    check_folder(output)
    parts = parts_of(problems, windows, stream or StreamPlan())
    jobs = Jobs[Part](single_threaded=True)
    raced = kept_results(
        "speed", race_part, parts, output, jobs=jobs, identity=lambda part: timing_identity()
    )
    rows = [row for each in raced for row in each.rows]
    left_out: dict[str, str] = {}
    for part, each in zip(parts, raced, strict=True):
        if isinstance(part, WindowRace):
            write_problem(part.problem, each.arrays, output)
        for sentence in each.warned:
            warnings.warn(sentence, RuntimeWarning, stacklevel=2)
        for name, reason in each.left_out.items():
            left_out.setdefault(name, reason)
    write_rows(rows, output / "speed.json")
    save(contender_figure(rows), output / "speed.png")
    save(horizon_figure(rows), output / "speed_horizon.png")
    for name, reason in left_out.items():
        console.print(f"left out: {name}: {reason}")
    _print_rows(rows)
    _print_verdicts(verdicts(rows, left_out=left_out))
    console.print(
        f"\nPython {platform.python_version()}, {platform.machine()}, one thread, "
        f"pen-mhe {version('pen-mhe')}; speed.json, problems and figures in {output}"
    )
    return rows


def _print_rows(rows: Sequence[Row]) -> None:
    times = ["CPU min", "CPU median", "wall min", "wall median", "wall p99"]
    qualities = ["cost", "error/std", "violation/std", "solved"]
    who, last = ["contender", "mode"], ["build", "CPU time by", "core", "version"]
    columns = ["problem", "N", "active", *who, *times, *qualities, *last]
    texts = [
        [
            row.problem,
            str(row.horizon),
            "" if row.active_rows is None else f"{row.active_rows:.1f}",
            row.contender,
            row.mode,
            in_unit(row.cpu_min_s),
            in_unit(row.cpu_median_s),
            in_unit(row.min_s),
            in_unit(row.median_s),
            in_unit(row.p99_s),
            "" if row.cost is None else f"{row.cost:.10g}",
            "" if row.newest_error_std is None else f"{row.newest_error_std:.1e}",
            "" if row.violation_std is None else f"{row.violation_std:.1e}",
            f"{row.solved:.0%}",
            in_unit(row.build_s),
            row.clock,
            f"{row.core_share:.0%}",
            row.version,
        ]
        for row in rows
    ]
    print_table("Time per window or sample", columns, texts)


def _print_verdicts(found: Sequence[PromiseVerdict]) -> None:
    texts = [
        [v.promise.text, _figure(v.promise, v.figure), _target(v.promise), _judged(v)]
        for v in found
    ]
    print_table("\nWhat was promised", ["", "figure", "target", ""], texts)


def _judged(verdict: PromiseVerdict) -> str:
    return verdict.unjudged if verdict.kept is None else JUDGED[verdict.kept]


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
