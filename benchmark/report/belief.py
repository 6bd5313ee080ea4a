"""What it costs to estimate a pen that spins by a model that cannot."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from benchmark.configurations import CONFIGURATIONS
from benchmark.report.choice import reliable
from benchmark.report.matrix import MATRIX, NO_FIGURE, Matrix, in_order, matrices
from benchmark.report.numbers import number
from benchmark.tasks.task import OK

if TYPE_CHECKING:
    import pandas as pd

SUITE, BELIEVING = MATRIX[0].suite, "spin ignored"
"""The case with the motion of the answer, of estimators whose pen cannot spin."""

QUANTITY = "elevation"


def costs_of_belief(rows: pd.DataFrame) -> list[str]:
    """Return a sentence per choice of sensors: what no spin believed gives, and the free pen.

    Each with the estimator that has the smallest median there: the belief at its best.
    """
    mine = rows[
        (rows["suite"] == SUITE)
        & (rows["case"] == BELIEVING)
        & (rows["quantity"] == QUANTITY)
        & (rows["status"] == OK)
    ]
    free = next((m for m in matrices(rows, MATRIX) if m.quantity == QUANTITY), None)
    found = []
    for sensors in in_order(mine["sensors"], CONFIGURATIONS):
        columns = ["estimator", "rmse", "claimed"]
        medians = mine[mine["sensors"] == sensors][columns].groupby("estimator", observed=True)
        best = medians.median().dropna(subset="rmse").sort_values("rmse", kind="stable")
        if not len(best):
            continue
        error, claimed, unit = *map(float, best.iloc[0]), str(mine["unit"].iloc[0])
        sure = f", claiming {number(claimed)}" if math.isfinite(claimed) else ""
        found.append(
            f"{sensors}: {QUANTITY} {number(error)} {unit} off{sure} (with {best.index[0]}); "
            f"{_of_free_pen(free, sensors, error)}."
        )
    return found


def _of_free_pen(free: Matrix | None, sensors: str, error: float) -> str:
    if free is None or sensors not in free.sensors:
        return "the free pen did not run"
    cells = reliable(free, sensors)
    if not cells:
        states = {free.cell(sensors, name).state for name in free.estimators}
        return f"of the free pen: {states.pop() if len(states) == 1 else NO_FIGURE}"
    name, cell = min(cells.items(), key=lambda entry: entry[1].median)
    times = f", {number(error / cell.median)} times less" if cell.median else ""
    return f"the free pen {number(cell.median)} {free.unit} (with {name}{times})"
