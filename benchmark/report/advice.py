"""One piece of advice per quantity, by rule from the numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from benchmark.report.matrix import NOT_OBSERVABLE, SHOWN, Cell, Matrix
from benchmark.report.numbers import interval, number
from benchmark.tasks.task import OK
from benchmark.verdicts.paired import BETTER, SAME, WORSE, paired

if TYPE_CHECKING:
    import pandas as pd

SIMPLE, OPTIMISING = "ekf", ("mhe-rti", "mhe")
"""The estimators of the question whether optimising pays, cheap ones first."""

CONVERGED = OPTIMISING[-1]
ENOUGH = 1.05
"""A cheaper estimator is taken where its median is at most so many times the best one's."""


@dataclass(frozen=True)
class Advice:
    """What to take, in one sentence, and what else there is."""

    take: str
    more: str


def advice(matrix: Matrix) -> Advice:
    """Say what to take for a quantity, whether the MHE pays there, and what is next.

    1. The sensors are those of the smallest median RMSE, whichever estimator has it.
    2. With them, an MHE pays where its RMSE, run by run, is below the EKF's with 95 %
       confidence, and by more than one percent. Else the EKF is to be taken. Which MHE: the
       cheapest whose median is about as good as the best one's.
    3. Next are the sensors with the smallest median RMSE among the others.
    """
    ranked = _ranked(matrix)
    if not ranked:
        return Advice("Nothing in this run gives it: there is nothing to advise.", "")
    cell, sentences = ranked[0][2], []
    if len(ranked) > 1:
        other, its, next_cell = ranked[1]
        times = f" ({number(next_cell.median / cell.median)} times)" if cell.median else ""
        sentences.append(
            f"Next: {other}, {number(next_cell.median)} {matrix.unit} with {its}{times}."
        )
    blind = [
        name
        for name, row in zip(matrix.sensors, matrix.cells, strict=True)
        if any(c.state == NOT_OBSERVABLE for c in row) and not any(c.state == SHOWN for c in row)
    ]
    if blind:
        sentences.append(f"Not observable with {_listed(blind)}.")
    return Advice(_take(matrix, *ranked[0]), " ".join(sentences))


def _ranked(matrix: Matrix) -> list[tuple[str, str, Cell]]:
    """Return the best estimator of every configuration that has one, the best first."""
    found = []
    for sensors, row in zip(matrix.sensors, matrix.cells, strict=True):
        cells = zip(matrix.estimators, row, strict=True)
        shown = [(name, cell) for name, cell in cells if math.isfinite(cell.median)]
        if shown:
            found.append((sensors, *min(shown, key=lambda entry: entry[1].median)))
    return sorted(found, key=lambda entry: entry[2].median)


def _take(matrix: Matrix, sensors: str, estimator: str, cell: Cell) -> str:
    rows = matrix.rows
    mine = rows[(rows["sensors"] == sensors) & (rows["quantity"] == matrix.quantity)]
    other = _cheapest_good(matrix, sensors)
    table = paired(mine, SIMPLE, other)
    if not len(table):
        return (
            f"Take {sensors} with {estimator} ({number(cell.median)} {matrix.unit}); whether an "
            "MHE pays is open, because no run has both EKF and MHE."
        )
    found = table.iloc[0]
    verdict, difference = str(found["verdict"]), float(found["difference"])
    ends = interval(float(found["low"]), float(found["high"]))
    pays = verdict == BETTER and bool(ends)
    take = other if pays else SIMPLE
    relative = (
        f" ({number(100 * abs(difference) / found[SIMPLE])}\N{NO-BREAK SPACE}%)"
        if found[SIMPLE]
        else ""
    )
    size = f"{number(abs(difference))} {matrix.unit}{relative}"
    way = "below" if difference < 0 else "above"
    shown = f"95 % interval of {other} minus EKF: {ends} {matrix.unit}"
    median = number(matrix.cell(sensors, take).median)
    start = f"Take {sensors} with {take} ({median} {matrix.unit}):"
    if pays:
        return f"{start} optimising pays, {size} below the EKF ({shown}){_cost(mine, other)}."
    if not ends:
        return (
            f"{start} {other} is {size} {way} the EKF, but the seeds of this run give no "
            "interval to tell whether it pays."
        )
    if verdict == SAME:
        return f"{start} {other} gives {verdict}{_cost(mine, other)}."
    if verdict == WORSE:
        return f"{start} optimising does not pay, {size} above the EKF ({shown})."
    worst = ", ".join(
        f"{number(matrix.cell(sensors, name).high)} with {name}" for name in (SIMPLE, other)
    )
    return (
        f"{start} no difference to {other} is shown ({shown}){_cost(mine, other)}; "
        f"the worst seed: {worst}."
    )


def _cheapest_good(matrix: Matrix, sensors: str) -> str:
    """Return the first of `OPTIMISING` that is about as good as the best of them; empty if none."""
    medians = {
        name: matrix.cell(sensors, name).median for name in OPTIMISING if name in matrix.estimators
    }
    finite = {name: median for name, median in medians.items() if math.isfinite(median)}
    return next(
        (name for name, median in finite.items() if median <= ENOUGH * min(finite.values())), ""
    )


def _cost(rows: pd.DataFrame, other: str) -> str:
    ran = rows[rows["status"] == OK]
    ekf, mhe = (
        ran[ran["estimator"] == name]["step_time_median_s"].median() for name in (SIMPLE, other)
    )
    if not (ekf > 0 and mhe > 0):
        return ""
    return f", at {number(mhe / ekf)} times the time per step"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"
