"""The work behind ``pen-mhe optimum``: does the real-time MHE end where IPOPT ends?"""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from itertools import groupby
from pathlib import Path

import pandas as pd

from benchmark.console import console, print_table
from benchmark.runner.kept import Jobs, kept_results
from estimation.output_folder import check_folder
from recordings.formats.tables import write_table
from suites.optimum.cases import WindowKey, window_bodies, window_table
from suites.optimum.kinds import KINDS
from suites.optimum.reference import LONGEST_LEFT
from suites.optimum.run import (
    ABOVE,
    BELOW,
    COST_LIMIT,
    IPOPT_FAILED,
    NEWEST_LIMIT,
    SAME,
    WindowRow,
    WindowSummary,
    compare,
    summary,
)

WINDOWS_PER_TASK = 10


def run_optimum(output: Path, windows: int, jobs: int, seed: int = 0) -> None:
    """Compare on a seeded table of windows; print counts and lists, write ``optimum.csv``.

    Parameters
    ----------
    output : folder to write to
    windows : number of them, see `suites.optimum.cases.window_table`
    jobs : processes
    seed : of the first window
    """
    check_folder(output)
    rows = compare_all(window_table(windows, seed), output, jobs)
    write_table(as_table(rows), output / "optimum.csv")
    _print_parts("configuration", {name: name for name in window_bodies()}, rows, _model)
    console.print()
    _print_parts("windows", {name: kind.label for name, kind in KINDS.items()}, rows, _kind)
    _print_summary(summary(rows))
    console.print(
        f"\nPython {platform.python_version()}, casadi {version('casadi')}, "
        f"numpy {version('numpy')}, pen-mhe {version('pen-mhe')}; table in {output}"
    )


def compare_all(keys: Sequence[WindowKey], folder: Path, jobs: int) -> list[WindowRow]:
    """Compare windows in processes; rows in the order of the keys.

    Parameters
    ----------
    folder : keeps what is finished
    """
    found = kept_results("optimum", _run, _tasks(keys), folder, jobs=Jobs(jobs, row=_problem))
    by_key = {row.key: row for rows in found for row in rows}
    return [by_key[key] for key in keys]


def as_table(rows: Sequence[WindowRow]) -> pd.DataFrame:
    """Return one line per window, statuses by name."""
    return pd.DataFrame(
        {
            **asdict(row.key),
            **{name: value for name, value in vars(row).items() if name != "key"},
            "reason": row.reason,
            "status": row.status.label,
            "ipopt_status": row.ipopt_status.label,
        }
        for row in rows
    )


def _tasks(keys: Sequence[WindowKey]) -> list[tuple[WindowKey, ...]]:
    """Return few windows at a time, of one model and horizon: solvers are built for these."""
    alike = sorted(keys, key=lambda key: _problem([key]))
    groups = [tuple(group) for _, group in groupby(alike, lambda key: _problem([key]))]
    return [
        group[first : first + WINDOWS_PER_TASK]
        for group in groups
        for first in range(0, len(group), WINDOWS_PER_TASK)
    ]


def _problem(keys: Sequence[WindowKey]) -> tuple[str, int]:
    return keys[0].model, keys[0].horizon


def _run(keys: Sequence[WindowKey]) -> list[WindowRow]:
    return [compare(key) for key in keys]


def _model(row: WindowRow) -> str:
    return row.key.model


def _kind(row: WindowRow) -> str:
    return row.key.kind


def _print_parts(
    title: str,
    labels: Mapping[str, str],
    rows: Sequence[WindowRow],
    part: Callable[[WindowRow], str],
) -> None:
    """Print a row of counts and worst distances per part that there is."""
    lines = []
    for name, label in labels.items():
        some = [row for row in rows if part(row) == name]
        if not some:
            continue
        found = summary(some)
        counts = [str(count) for count in (len(some), *found.verdicts.values(), len(found.missed))]
        worst = [f"{found.newest_distance:.1e}", f"{found.relative:.1e}"]
        lines.append([label, *counts, *worst])
    print_table(
        f"mhe against IPOPT from the same start, {len(rows)} windows, by {title}",
        [
            title,
            "windows" if title != "windows" else "number",
            *summary(rows).verdicts,
            "same, but apart",
            "newest apart / std",
            "costs apart, relative",
        ],
        lines,
    )


def _print_summary(found: WindowSummary) -> None:
    counts = found.verdicts
    console.print(
        f"\nsame minimum: {counts[SAME]}, of which {len(found.missed)} are farther apart than "
        f"{NEWEST_LIMIT:g} standard deviations or {COST_LIMIT:g} of the cost"
        f"\nIPOPT had to be carried on with the exact Hessian: {found.carried_on}"
        f"\nIPOPT failed: {counts[IPOPT_FAILED]}, its Newton step left is longer than "
        f"{LONGEST_LEFT:g}; in {found.near_anyway} of them mhe is within {NEWEST_LIMIT:g}"
    )
    lists = {
        "farther apart than that": found.missed,
        f"{ABOVE} IPOPT's minimum": found.above,
        f"{BELOW} IPOPT's minimum": found.below,
        IPOPT_FAILED: found.ipopt_failed,
    }
    for title, rows in lists.items():
        if rows:
            console.print()
            print_table(title, LISTED, [_listed(row) for row in rows])


LISTED = [
    "seed",
    "model",
    "kind",
    "N",
    "cost",
    "relative",
    "newest / std",
    "reason",
]


def _listed(row: WindowRow) -> list[str]:
    key = row.key
    return [
        str(key.seed),
        key.model,
        key.kind,
        str(key.horizon),
        f"{row.cost:.6g}",
        f"{row.relative:+.1e}",
        f"{row.newest_distance:.1e}",
        row.reason,
    ]
