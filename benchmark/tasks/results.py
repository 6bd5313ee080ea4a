"""The results of a benchmark run as tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmark.figures.figure import Line
from models.arrays import Array

if TYPE_CHECKING:
    import pandas as pd

TASK_COLUMNS = ("suite", "case", "sensors", "estimator", "seed")
RESULT_COLUMNS = (
    "suite",
    "case",
    "model",
    "sensors",
    "estimator",
    "seed",
    "quantity",
    "unit",
    "rmse",
    "bias",
    "max_error",
    "observable",
    "claimed",
    "samples",
    "solved_fraction",
    "step_time_median_s",
    "step_time_p99_s",
    "status",
    "reason",
)
"""Columns of ``results.parquet``: one row per task and quantity."""

TIMING_COLUMNS = ("step_time_median_s", "step_time_p99_s")
"""The columns that differ from run to run."""

SERIES_COLUMNS = (*TASK_COLUMNS, "quantity", "unit", "time_s", "estimate", "std", "truth")
"""Columns of ``series.parquet``: one row per instant of a series; NaN where there is none."""


@dataclass(frozen=True, eq=False)
class Results:
    """Tables of a run.

    Parameters
    ----------
    rows : with `RESULT_COLUMNS`
    series : with `SERIES_COLUMNS`
    """

    rows: pd.DataFrame
    series: pd.DataFrame

    def of(self, suite: str) -> Results:
        """Return one suite's part."""
        return Results(
            self.rows[self.rows["suite"] == suite], self.series[self.series["suite"] == suite]
        )

    def select(self, **values: object) -> pd.DataFrame:
        """Return the rows in which columns have given values: one each, or a list of them."""
        return _where(self.rows, values)

    def lines(self, name: str, truth: bool = False, **values: object) -> Line | None:
        """Return one series as a line with its band; None where the run has it not.

        Parameters
        ----------
        name : of the line
        truth : take the truth instead of the estimate
        values : column → value that picks the one series
        """
        found = _where(self.series, values)
        if not len(found):
            return None
        y, std = _column(found, "truth" if truth else "estimate"), _column(found, "std")
        band = None if truth or np.isnan(std).all() else std
        return Line(name, _column(found, "time_s"), y, band)


def _where(table: pd.DataFrame, values: Mapping[str, object]) -> pd.DataFrame:
    for column, value in values.items():
        wanted = list(value) if isinstance(value, (list, tuple)) else [value]
        table = table[table[column].isin(wanted)]
    return table


def _column(table: pd.DataFrame, name: str) -> Array:
    return np.asarray(table[name].to_numpy(dtype=float))
