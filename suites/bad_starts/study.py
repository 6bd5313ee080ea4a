"""The work behind ``pen-mhe bad-starts``: wrong starts in processes, tables and a figure."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmark.console import console, print_table
from benchmark.runner.kept import Jobs, kept_results
from estimation.output_folder import check_folder
from models.arrays import Array
from pen_mhe.estimators import check_estimator
from pen_mhe.figures import save
from recordings.formats.tables import write_table
from suites.bad_starts.cases import CASES, KNOWLEDGE, case_named
from suites.bad_starts.run import (
    AT_S,
    FIRST_S,
    WITHIN_DEG,
    WITHIN_STD,
    BadStartRun,
    as_table,
    run_bad_start,
    summary,
)

RUNS_PER_TASK = 10

FIGURE_CASES = ("writing-30", "writing-170", "calibrated-170", "strokes-30")
"""A row of the figure each, where they were run."""

WIDTH = 8.4
"""Of the figure in inches: what a page is wide, so that its text can be read there."""

Runs = Mapping[tuple[str, str], Sequence[BadStartRun]]
"""(case, estimator) → its runs, by seed."""


def _median_and_p90(quantity: str) -> Callable[[Mapping[str, Any]], str]:
    return lambda row: f"{row[f'{quantity}_median']:.2g} ({row[f'{quantity}_p90']:.2g})"


def _over_time(row: Mapping[str, Any]) -> str:
    parts = (
        (np.degrees(row[f"up_{after_s:g}_s_rad_{of}"]) for of in ("median", "p90"))
        for after_s in AT_S
    )
    return "; ".join(f"{median:.2g} ({p90:.2g})" for median, p90 in parts if np.isfinite(median))


TABLES: Mapping[str, Callable[[Mapping[str, Any]], str]] = MappingProxyType(
    {
        f"up, error after {', '.join(f'{t:g}' for t in AT_S)} s / °: median (90 %)": _over_time,
        "body rates, RMS error of the first second / (rad/s): median (90 %)": _median_and_p90(
            "rate_rms_rad_s"
        ),
        f"after 1 s: runs within {WITHIN_DEG:g}°, within {WITHIN_STD:g} claimed deviations": (
            lambda row: f"{row['within_3_deg']:.0%}, {row['within_3_std']:.0%}"
        ),
        "end error over claimed deviation, median (honest: 1.18; without spin 0.67)": (
            lambda row: f"{row['end_error_per_std']:.2g}"
        ),
    }
)
"""Title → the cell of a case and an estimator, from its row of `summary`."""

QUANTITIES: Mapping[str, Callable[[BadStartRun], Array]] = MappingProxyType(
    {
        "error of up / rad": lambda run: run.error,
        "body rate error / (rad/s)": lambda run: run.rate_error,
    }
)
"""Label → what a row of the figure shows of a run, (n,)."""


@dataclass(frozen=True)
class BadStartTask:
    """A few runs of one case by one estimator."""

    case: str
    estimator: str
    seeds: range

    def pair(self) -> tuple[str, str]:
        """Return case and estimator: one is built for all runs of them."""
        return self.case, self.estimator


def run_bad_starts(
    output: Path, cases: Sequence[str], estimators: Sequence[str], runs: int, jobs: int
) -> None:
    """Run every case with every estimator; print tables, write ``bad_starts.csv`` and ``.png``."""
    for case in cases:
        case_named(case)
    for estimator in estimators:
        check_estimator(estimator)
    check_folder(output)
    tasks = [
        BadStartTask(case, estimator, range(first, min(first + RUNS_PER_TASK, runs)))
        for case in cases
        for estimator in estimators
        for first in range(0, runs, RUNS_PER_TASK)
    ]
    found = kept_results(
        "bad-starts", _run_task, tasks, output, jobs=Jobs(jobs, row=BadStartTask.pair)
    )
    by_pair: dict[tuple[str, str], list[BadStartRun]] = {}
    for task, of_task in zip(tasks, found, strict=True):
        by_pair.setdefault(task.pair(), []).extend(of_task)
    rows = {
        (case, estimator): summary(case_named(case), estimator, of_pair)
        for (case, estimator), of_pair in by_pair.items()
    }
    write_table(as_table(rows.values()), output / "bad_starts.csv")
    shown = [case for case in FIGURE_CASES if case in cases] or list(cases)[:4]
    save(bad_starts_figure(by_pair, shown, estimators), output / "bad_starts.png")
    for title, cell in TABLES.items():
        _print(f"{title}; {runs} runs each", cases, estimators, rows, cell)
        console.print()
    console.print(
        f"Python {platform.python_version()}, casadi {version('casadi')}, "
        f"pen-mhe {version('pen-mhe')}; table and figure in {output}"
    )


def _run_task(task: BadStartTask) -> list[BadStartRun]:
    case = case_named(task.case)
    return [run_bad_start(case, task.estimator, seed) for seed in task.seeds]


def _print(
    title: str,
    cases: Sequence[str],
    estimators: Sequence[str],
    rows: Mapping[tuple[str, str], Mapping[str, Any]],
    cell: Callable[[Mapping[str, Any]], str],
) -> None:
    lines = []
    for name in cases:
        case = CASES[name]
        told = KNOWLEDGE[case.knowledge].label
        cells = [cell(rows[name, estimator]) for estimator in estimators]
        lines.append([case.label, told, case.start, *cells])
    print_table(title, ["case", "told", "start wrong by / °", *estimators], lines)


def bad_starts_figure(runs: Runs, cases: Sequence[str], estimators: Sequence[str]) -> Figure:
    """Draw errors over time, a row per case: median and 10 to 90 % band of the runs."""
    figure, grid = plt.subplots(
        len(cases),
        len(QUANTITIES),
        figsize=(WIDTH, 1.0 + 2.3 * len(cases)),
        layout="constrained",
        sharex=True,
        sharey="col",
        squeeze=False,
    )
    for row, name in zip(grid, cases, strict=True):
        case = CASES[name]
        told = KNOWLEDGE[case.knowledge].label
        row[0].set_title(
            f"{case.label}, start wrong by {case.start}°, told: {told}", fontsize=10, loc="left"
        )
        for axes, (label, quantity) in zip(row, QUANTITIES.items(), strict=True):
            axes.set_ylabel(label)
            for place, estimator in enumerate(estimators):
                of_pair = runs[name, estimator]
                errors = np.array([quantity(run) for run in of_pair])
                _draw(axes, of_pair[0].time_s, errors, estimator, f"C{place}")
            axes.set_yscale("log")
            axes.grid(alpha=0.3)
    for axes in grid[-1]:
        axes.set_xlabel("time / s")
    grid[0, 0].legend(fontsize=10, loc="lower left")
    count = len(runs[cases[0], estimators[0]])
    figure.suptitle(
        f"A wrong attitude at the start: median and 10–90 % of {count} runs", fontsize=11
    )
    return figure


def _draw(axes: Axes, time_s: Array, errors: Array, label: str, color: str) -> None:
    low, median, high = np.quantile(errors, [0.1, 0.5, 0.9], axis=0)
    axes.fill_between(time_s, low, high, color=color, alpha=0.2, linewidth=0)
    axes.plot(time_s, median, color=color, linewidth=1.2, label=label)
    axes.axvline(FIRST_S, color="0.5", linewidth=0.6, linestyle=":")
