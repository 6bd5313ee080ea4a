"""The answer: how well each configuration of sensors does with each estimator."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmark.configurations import CONFIGURATIONS, SensorConfiguration
from benchmark.figures.style import NAMED
from benchmark.tasks.task import OK
from models.border import reading

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Selection:
    """Which rows of the results make matrices: quantities of one case of a suite."""

    suite: str
    case: str
    quantities: tuple[str, ...]


MATRIX = (
    Selection(
        "pen", "free pen, handwriting", ("elevation", "rates", "spin", "azimuth", "tip")
    ),
)  # fmt: skip
"""The quantities that the report begins with, in its order: a pen that spins in the hand."""

NO_SPIN = (Selection("pen", "no-spin pen, handwriting", ("elevation", "rates", "azimuth", "tip")),)
"""The quantities of the pen of [Pen], which cannot spin. They stand apart."""

OWN_PEN = "own-pen"
"""The suite whose matrices are about a pen of one's own."""

LEVELS = (1.1, 1.5, 3.0, 10.0)
"""Ratios to the best median: a cell's level is the number of those that it exceeds."""

SHOWN, NOT_OBSERVABLE, NO_FIGURE = "shown", "not observable", "no figure"
FAILED, NOT_RUN = "failed", "not run"


@dataclass(frozen=True)
class Cell:
    """One configuration with one estimator.

    Parameters
    ----------
    state : `SHOWN`, or the words that stand instead of a figure
    median, low, high : of the RMSE over seeds, smallest, largest; NaN unless shown
    claimed : median over seeds of the claimed standard deviation; NaN where none is claimed
    worst_by_claim : RMSE of the worst seed over what it claims, likewise
    seeds, of : runs that count, and all runs
    level : 0 for figures next to the best, up to ``len(LEVELS)``
    best : whether it has the smallest median
    """

    state: str
    median: float = float("nan")
    low: float = float("nan")
    high: float = float("nan")
    claimed: float = float("nan")
    worst_by_claim: float = float("nan")
    seeds: int = 0
    of: int = 0
    level: int = len(LEVELS)
    best: bool = False


@dataclass(frozen=True)
class Matrix:
    """Sensors × estimators for one quantity.

    Parameters
    ----------
    cells : of a row for each of `sensors`, with one for each of `estimators`
    rows : the results that they come from, of all quantities of the case
    configurations : what is known of `sensors`, from cheap to dear
    """

    suite: str
    case: str
    quantity: str
    unit: str
    sensors: tuple[str, ...]
    estimators: tuple[str, ...]
    cells: tuple[tuple[Cell, ...], ...]
    rows: pd.DataFrame
    configurations: Mapping[str, SensorConfiguration] = field(
        default_factory=lambda: CONFIGURATIONS
    )

    def cell(self, sensors: str, estimator: str) -> Cell:
        """Return one cell."""
        return self.cells[self.sensors.index(sensors)][self.estimators.index(estimator)]


def own_selections(rows: pd.DataFrame) -> list[Selection]:
    """Return the quantities of a pen of one's own, where the results have any."""
    cases = dict.fromkeys(map(str, rows[rows["suite"] == OWN_PEN]["case"]))
    return [Selection(OWN_PEN, case, MATRIX[0].quantities) for case in cases]


def configurations_of(run: Mapping[str, Any]) -> Mapping[str, SensorConfiguration]:
    """Return the choices of sensors that a run is about: the benchmark's unless it says others."""
    own = run.get("configurations")
    if not own:
        return CONFIGURATIONS
    with reading("run.json: key configurations", "what a run wrote"):
        return {
            row["label"]: SensorConfiguration(**{**row, "sensors": tuple(row["sensors"])})
            for row in own
        }


def matrices(
    rows: pd.DataFrame,
    selections: Sequence[Selection] = MATRIX,
    configurations: Mapping[str, SensorConfiguration] = CONFIGURATIONS,
) -> list[Matrix]:
    """Return the matrix of every selected quantity that the results have."""
    found: list[Matrix] = []
    for chosen in selections:
        case = rows[(rows["suite"] == chosen.suite) & (rows["case"] == chosen.case)]
        found += [
            _matrix(case, chosen, quantity, configurations)
            for quantity in chosen.quantities
            if (case["quantity"] == quantity).any()
        ]
    return found


def _matrix(
    case: pd.DataFrame,
    chosen: Selection,
    quantity: str,
    configurations: Mapping[str, SensorConfiguration],
) -> Matrix:
    mine = case[case["quantity"] == quantity]
    sensors = in_order(case["sensors"], configurations)
    estimators = in_order(case["estimator"], NAMED)
    cells = {(s, e): _cell(case, mine, s, e) for s in sensors for e in estimators}
    medians = [cell.median for cell in cells.values() if np.isfinite(cell.median)]
    best = min(medians, default=float("nan"))
    return Matrix(
        chosen.suite,
        chosen.case,
        quantity,
        str(mine["unit"].iloc[0]),
        sensors,
        estimators,
        tuple(tuple(_graded(cells[s, e], best) for e in estimators) for s in sensors),
        case,
        configurations,
    )


def _cell(case: pd.DataFrame, mine: pd.DataFrame, sensors: str, estimator: str) -> Cell:
    runs = _of(case, sensors, estimator)
    rows = _of(mine, sensors, estimator)
    of = runs["seed"].nunique()
    if not of:
        return Cell(NOT_RUN)
    if not (runs["status"] == OK).any():
        return Cell(FAILED, of=of)
    ran = rows[rows["status"] == OK]
    seen = ran[ran["observable"].eq(True) & ran["rmse"].notna()]
    if not len(seen):
        blind = len(ran) > 0 and not ran["observable"].eq(True).any()
        return Cell(NOT_OBSERVABLE if blind else NO_FIGURE, of=of)
    rmse = seen["rmse"].to_numpy(dtype=float)
    # The median of two infinite figures is one, but numpy takes their mean for no number.
    median = float(np.median(rmse)) if np.isfinite(rmse).all() else _lower_median(rmse)
    claimed = seen["claimed"].to_numpy(dtype=float)
    at_worst = claimed[rmse.argmax()]
    return Cell(
        SHOWN,
        median,
        float(rmse.min()),
        float(rmse.max()),
        float(np.median(claimed)),
        float(rmse.max() / at_worst) if at_worst > 0 else float("nan"),
        seen["seed"].nunique(),
        of,
    )


def _lower_median(values: np.ndarray) -> float:
    return float(np.quantile(values, 0.5, method="higher"))


def _of(table: pd.DataFrame, sensors: str, estimator: str) -> pd.DataFrame:
    return table[(table["sensors"] == sensors) & (table["estimator"] == estimator)]


def _graded(cell: Cell, best: float) -> Cell:
    if cell.state != SHOWN:
        return cell
    level = sum(not cell.median <= limit * best for limit in LEVELS)
    return replace(cell, level=level, best=cell.median == best)


def in_order(names: Iterable[object], first: Iterable[str]) -> tuple[str, ...]:
    """Return each name once: those of a table in its order, then the others as they come."""
    present = dict.fromkeys(str(name) for name in names)
    return tuple(
        [name for name in first if name in present]
        + [name for name in present if name not in set(first)]
    )
