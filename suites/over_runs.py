"""What many runs have over time: their middle, and what holds the most of them."""

from __future__ import annotations

from typing import Literal

import numpy as np

from benchmark.figures.figure import Line
from benchmark.tasks.results import Results

ENDS = (0.1, 0.9)
"""Quantiles that the band reaches to."""


def over_runs(
    results: Results, name: str, middle: Literal["mean", "median"], **values: object
) -> Line | None:
    """Return the mean or median of runs at every instant, and the band of 10 to 90 % of them.

    Parameters
    ----------
    results : whose series are read; runs of one cell share their instants
    name : of the line
    values : column → value that picks the cell; None is returned where it has no series
    """
    series = results.series
    for column, value in values.items():
        series = series[series[column] == value]
    if not len(series):
        return None
    at = series.groupby("time_s")["estimate"]
    low, high = (at.quantile(end).to_numpy(dtype=float) for end in ENDS)
    line = at.mean() if middle == "mean" else at.median()
    times = np.asarray(line.index, dtype=float)
    return Line(name, times, line.to_numpy(dtype=float), band=(low, high))
