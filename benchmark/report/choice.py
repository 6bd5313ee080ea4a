"""Which estimator may be named with a choice of sensors, by rule from the numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from benchmark.report.matrix import SHOWN, Cell, Matrix
from benchmark.report.numbers import interval, number
from benchmark.tasks.task import OK
from benchmark.verdicts.paired import BETTER, SAME, WORSE, paired

if TYPE_CHECKING:
    import pandas as pd

SIMPLE, OPTIMISING = "ekf", ("mhe-rti", "mhe")
"""The estimators of the question whether optimising pays, cheap ones first."""

CONVERGED = OPTIMISING[-1]
NO_INTERVAL = "the seeds of this run give no interval to tell whether it pays"
ENOUGH = 1.05
"""What is cheaper is taken where its median is at most so many times the best one's."""


BEYOND = 2.0
"""A worst seed so many times another estimator's is far beyond it, where it is also …"""

OWN_CLAIMS = 3.0
"""… more than so many of its own claimed deviations: an error that its estimator does not know."""

WHATEVER_CLAIMED = 10.0
"""So many times another's it is far beyond, whatever it claims."""


def worst(cell: Cell) -> float:
    """Return the largest RMSE over seeds; infinite where a seed has no figure."""
    return cell.high if cell.seeds == cell.of else math.inf


def is_far_beyond(cell: Cell, other: Cell) -> bool:
    """Whether the worst seed of a cell forbids it beside another cell, with the same sensors."""
    mine, its = worst(cell), worst(other)
    if not mine > BEYOND * its:
        return False
    # An estimator that claims nothing cannot excuse itself.
    return mine > WHATEVER_CLAIMED * its or not cell.worst_by_claim <= OWN_CLAIMS


def figures_of(matrix: Matrix, sensors: str) -> Mapping[str, Cell]:
    """Return estimator → its cell, of those with a finite median."""
    cells = {name: matrix.cell(sensors, name) for name in matrix.estimators}
    return {name: cell for name, cell in cells.items() if math.isfinite(cell.median)}


def reliable(matrix: Matrix, sensors: str) -> Mapping[str, Cell]:
    """Return estimator → its cell, of those whose worst seed is not far beyond another's."""
    found = figures_of(matrix, sensors)
    return {
        name: cell
        for name, cell in found.items()
        if not any(is_far_beyond(cell, other) for other in found.values())
    }


def is_unseen(matrix: Matrix, sensors: str, state: str) -> bool:
    """Whether all that a choice of sensors has is a state that stands instead of figures."""
    states = [matrix.cell(sensors, name).state for name in matrix.estimators]
    return state in states and SHOWN not in states


def chosen_estimator(matrix: Matrix, sensors: str) -> tuple[str, str]:
    """Return which estimator to take with sensors, and why; both empty where that is open."""
    cells, all_of_them = reliable(matrix, sensors), figures_of(matrix, sensors)
    other = _cheapest_good(cells)
    if not other and SIMPLE not in cells:
        return "", ""
    if SIMPLE not in cells and SIMPLE in all_of_them:
        return other, _beyond(matrix, sensors, SIMPLE, other)
    if not other and (bad := _cheapest_good(all_of_them)):
        return SIMPLE, _beyond(matrix, sensors, bad, SIMPLE)
    return _by_pairs(matrix, sensors, other)


def _beyond(matrix: Matrix, sensors: str, bad: str, take: str) -> str:
    """Say that the worst seed of an estimator is far beyond that of the one to take."""
    cell, its = (matrix.cell(sensors, name) for name in (bad, take))
    if cell.seeds < cell.of:
        return f"{bad} has no figure for {cell.of - cell.seeds} of {cell.of} seeds"
    claims = cell.worst_by_claim
    sure = f", {number(claims)} of its claimed deviations" if claims > 1 else ""
    return (
        f"the worst seed of {bad} is {number(worst(cell))} {matrix.unit}{sure}, far beyond "
        f"{number(worst(its))} with {take}"
    )


def _by_pairs(matrix: Matrix, sensors: str, other: str) -> tuple[str, str]:
    """Choose between EKF and an MHE, run by run; see rule 3 of `benchmark.report.advice.advice`."""
    rows, unit = matrix.rows, matrix.unit
    mine = rows[(rows["sensors"] == sensors) & (rows["quantity"] == matrix.quantity)]
    table = paired(mine, SIMPLE, other)
    if not len(table):
        return "", ""
    found = table.iloc[0]
    verdict, difference = str(found["verdict"]), float(found["difference"])
    ends = interval(float(found["low"]), float(found["high"]))
    relative = (
        f" ({number(100 * abs(difference) / found[SIMPLE])}\N{NO-BREAK SPACE}%)"
        if found[SIMPLE]
        else ""
    )
    size = f"{number(abs(difference))} {unit}{relative}"
    shown = f"95 % interval of {other} minus EKF: {ends} {unit}"
    if not ends:
        way = "below" if difference < 0 else "above"
        return SIMPLE, (f"{other} is {size} {way} the EKF, but {NO_INTERVAL}")
    if verdict == BETTER:
        return other, f"optimising pays, {size} below the EKF ({shown}){_cost(mine, other)}"
    if verdict == SAME:
        return SIMPLE, f"{other} gives {verdict}{_cost(mine, other)}"
    if verdict == WORSE:
        return SIMPLE, f"optimising does not pay, {size} above the EKF ({shown})"
    worst_of = ", ".join(
        f"{number(matrix.cell(sensors, name).high)} with {name}" for name in (SIMPLE, other)
    )
    return SIMPLE, (
        f"no difference to {other} is shown ({shown}){_cost(mine, other)}; "
        f"the worst seed: {worst_of}"
    )


def _cheapest_good(cells: Mapping[str, Cell]) -> str:
    """Return the first of `OPTIMISING` that is about as good as the best of them; empty if none."""
    medians = {name: cells[name].median for name in OPTIMISING if name in cells}
    return next(
        (name for name, median in medians.items() if median <= ENOUGH * min(medians.values())), ""
    )


def _cost(rows: pd.DataFrame, other: str) -> str:
    ran = rows[rows["status"] == OK]
    ekf, mhe = (
        ran[ran["estimator"] == name]["step_time_median_s"].median() for name in (SIMPLE, other)
    )
    if not (ekf > 0 and mhe > 0):
        return ""
    return f", at {number(mhe / ekf)} times the time per step"
