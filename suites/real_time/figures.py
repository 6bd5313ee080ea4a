"""The figure of the suite real-time: distance from full passes and time, over the threshold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel
from benchmark.tasks.results import Results
from benchmark.tasks.task import OK
from mhe.reuse import REUSE_THRESHOLD
from models.arrays import Array
from suites.real_time.cases import reuse_case
from suites.real_time.reuse import HORIZONS, NEWEST, THRESHOLDS, TIME, threshold_name
from suites.real_time.streams import STREAMS

DRAWN = [threshold for threshold in THRESHOLDS if math.isfinite(threshold)]
AIM, DEFAULT = "aimed at", "default threshold"
NEAR_STD = 0.05
PARTS: Mapping[int, float] = MappingProxyType({20: 1 / 2, 100: 1 / 3})
"""What is aimed at, as in the claims: a distance, and a part of a full pass' time by horizon."""


def figures(results: Results) -> Sequence[Figure]:
    """Return the figure, where there are rows of it."""
    shown = [N for N in HORIZONS if _lines(results, N, NEWEST, "rmse")]
    if not shown:
        return []
    threshold = "threshold (σ)"
    panels = [
        *(
            Panel(
                f"distance, N = {N}",
                threshold,
                "distance (σ)",
                _marked(_lines(results, N, NEWEST, "rmse"), NEAR_STD),
                x_log=True,
                y_log=True,
            )
            for N in shown
        ),
        *(
            Panel(
                f"time, N = {N}",
                threshold,
                "time / full pass",
                _marked(_lines(results, N, TIME, "bias"), PARTS[N]),
                x_log=True,
            )
            for N in shown
        ),
    ]
    return [
        Figure(
            "real-time-reuse",
            "Factors that stay: distance from full passes, and time per step",
            "Above, the newest state's distance from that of full passes (RMS), in its standard "
            "deviations σ; below, the median time of a step to theirs. Mean over the seeds, with "
            "the smallest and the largest.",
            panels,
            columns=len(shown),
        )
    ]


def _lines(results: Results, horizon: int, quantity: str, column: str) -> list[Line]:
    """Return a line per stream whose sensors hold all states."""
    lines = []
    for name, stream in STREAMS.items():
        values = [
            _values(results, reuse_case(name, horizon), threshold, quantity, column)
            for threshold in DRAWN
        ]
        there = [(x, v) for x, v in zip(DRAWN, values, strict=True) if len(v)]
        if stream.is_judged and there:
            x = np.array([threshold for threshold, _ in there])
            mean, low, high = (
                np.array([f(v) for _, v in there]) for f in (np.mean, np.min, np.max)
            )
            lines.append(Line(stream.label, x, mean, low=low, high=high))
    return lines


def _values(results: Results, case: str, threshold: float, quantity: str, column: str) -> Array:
    who = threshold_name(threshold)
    rows = results.select(case=case, estimator=who, quantity=quantity, status=OK)
    return np.asarray(rows[column], dtype=float)


def _marked(lines: Sequence[Line], aim: float) -> list[Line]:
    """Return lines with what is aimed at, and where the default is."""
    values = np.concatenate([[aim], *(line.y for line in lines)])
    ends = np.array([DRAWN[0], DRAWN[-1]])
    default = np.array([REUSE_THRESHOLD, REUSE_THRESHOLD])
    return [
        Line(AIM, ends, np.array([aim, aim]), style="dashed"),
        Line(DEFAULT, default, np.array([values.min(), values.max()]), style="dashed"),
        *lines,
    ]
