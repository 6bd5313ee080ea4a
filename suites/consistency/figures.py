"""NEES over time, and the tables of all cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel, Table
from benchmark.tasks.results import Results
from pen_mhe.estimators import ESTIMATORS
from recordings.motion_list import DRAWN
from suites.consistency.quantities import NEES, runs_of
from suites.consistency.run import CASES, SETTLED_S
from suites.over_runs import over_runs

if TYPE_CHECKING:
    import pandas as pd

LIMIT = 2.6
"""Standard errors within which a mean NEES counts as consistent: of 99 % of such estimators."""

EXPECTED = "expected"
HEAD = (
    *("Truth", "Estimator", f"NEES from {SETTLED_S:g} s on: mean of runs", "Expected"),
    *(
        "Away / standard errors",
        "At the first sample",
        "NIS per row",
        "Single states: error / deviation",
    ),
)


def figures(results: Results) -> Sequence[Figure]:
    """Return a figure per choice of sensors: NEES over time, a panel per case."""
    found = []
    for number, sensors in enumerate(dict.fromkeys(results.series["sensors"])):
        shown = {name: lines for name in CASES if (lines := _lines(results, sensors, name))}
        told = " ".join(f"{name}: {CASES[name].label}." for name in shown)
        found.append(
            Figure(
                f"consistency-{number + 1}",
                f"NEES over time: {sensors}",
                "Mean of the runs, and the band of 10 to 90 % of them. What is expected of a "
                f"consistent estimator is 1. A mean beyond the band comes from a few runs. {told}",
                [
                    Panel(name, "time (s)", "NEES / states", lines, y_log=True, own_x=True)
                    for name, lines in shown.items()
                ],
                columns=min(2, len(shown)),
            )
        )
    return found


def _lines(results: Results, sensors: str, case: str) -> list[Line]:
    cell = {"sensors": sensors, "case": case, "quantity": NEES}
    found = [over_runs(results, name, "mean", estimator=name, **cell) for name in ESTIMATORS]
    lines = [line for line in found if line is not None]
    if lines:
        ends = lines[0].x[[0, -1]]
        lines.append(Line(EXPECTED, ends, np.ones(2), style="dashed"))
    return lines


def tables(results: Results) -> Sequence[Table]:
    """Return a table per model and choice of sensors, a row per case and estimator."""
    rows = results.rows[results.rows["quantity"] != ""]
    caption = (
        f"Consistent: within {LIMIT:g} standard errors of the number of states. A standard error "
        "is that of the mean across runs, at most √(2 states / runs). A truth that is not drawn "
        "from the model proves nothing."
    )
    found = []
    for (model, sensors), part in rows.groupby(["model", "sensors"], observed=True, sort=False):
        cells = dict(iter(part.groupby(["case", "estimator"], observed=True)))
        runs = part["seed"].nunique()
        shown = [
            _row(case, name, cells[case, name])
            for case in CASES
            for name in ESTIMATORS
            if (case, name) in cells
        ]
        found.append((f"{model}: {sensors}, {runs} runs each", caption, HEAD, shown))
    return found


def _row(case: str, estimator: str, rows: pd.DataFrame) -> tuple[str, ...]:
    runs, chosen = runs_of(rows), CASES[case]
    verdict = "not drawn from the model"
    if chosen.motion == DRAWN:
        verdict = "consistent" if abs(runs.deviation) <= LIMIT else "not consistent"
    return (
        chosen.label,
        estimator,
        f"{runs.nees.mean():.4g} (median {np.median(runs.nees):.4g})",
        f"{runs.n_x}",
        f"{runs.deviation:+.1f} ({verdict})",
        f"{runs.first_nees.mean():.4g}",
        f"{np.mean(runs.nis_per_row):.3f}",
        f"{np.mean(runs.state_error):.3f}",
    )
