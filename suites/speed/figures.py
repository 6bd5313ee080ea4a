"""Figures of the suite speed: time per window by contender, and over the horizon."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from benchmark.report.numbers import in_unit
from suites.speed.contender import (
    BATCH,
    CONVERGED,
    CONVERGED_CALL,
    FULL_STREAM_CALL,
    ONE_PASS,
    PASS_CALL,
    STREAM_CALL,
)
from suites.speed.rows import Row

MODE_STYLES: Mapping[str, Mapping[str, Any]] = {
    ONE_PASS: {"color": "C0", "marker": "o"},
    PASS_CALL: {"color": "C0", "marker": "v"},
    CONVERGED: {"color": "C1", "marker": "s"},
    CONVERGED_CALL: {"color": "C1", "marker": "P"},
    BATCH: {"color": "C2", "marker": "D"},
    STREAM_CALL: {"color": "C0", "marker": "v"},
    FULL_STREAM_CALL: {"color": "C1", "marker": "v"},
}
WINDOW_MODES = (ONE_PASS, PASS_CALL, CONVERGED, CONVERGED_CALL)
REUSE_MODES = (STREAM_CALL, FULL_STREAM_CALL)
OTHER_MODE: Mapping[str, Any] = {"color": "C3", "marker": "^"}
TIME_LABEL = "time per window: median, to 99 % quantile"
HORIZON_PROBLEM = "pen15"
COLUMNS = 2
"""Panels beside each other: with more, their text is too small where the picture is looked at."""


def contender_figure(rows: Sequence[Row]) -> Figure:
    """Draw one panel per problem: contenders below each other, time on a log axis."""
    panels: dict[str, list[Row]] = {}
    for row in rows:
        panels.setdefault(_panel_of(row), []).append(row)
    columns = min(COLUMNS, len(panels))
    lines = -(-len(panels) // columns)
    figure, axes = plt.subplots(
        lines, columns, figsize=(4.8 * columns, 3.2 * lines), layout="constrained", squeeze=False
    )
    for axis, (title, found) in zip(axes.flat, panels.items(), strict=False):
        _draw_times(axis, found)
        axis.set_title(title, fontsize=10)
    for axis in axes.flat[len(panels) :]:
        axis.set_axis_off()
    for axis in axes[-1]:
        axis.set_xlabel(TIME_LABEL)
    return figure


def _panel_of(row: Row) -> str:
    """Return the title of the panel that a row belongs to."""
    if row.mode in WINDOW_MODES:
        return f"{row.problem}, N = {row.horizon}{', bounded' if row.bounds else ''}"
    if row.mode in REUSE_MODES:
        return f"{row.problem}, stream: factors kept, or full passes"
    return f"{row.problem}, stream: time per sample"


def _draw_times(axes: Axes, rows: Sequence[Row]) -> None:
    ordered = sorted(rows, key=lambda row: -row.median_s)
    for place, row in enumerate(ordered):
        style = MODE_STYLES.get(row.mode, OTHER_MODE)
        axes.plot([row.median_s, row.p99_s], [place, place], color=style["color"], linewidth=1.2)
        axes.plot(row.median_s, place, linestyle="none", markersize=6, **style)
        axes.annotate(
            in_unit(row.median_s),
            (row.median_s, place),
            xytext=(-5, 4),
            textcoords="offset points",
            ha="right",
            fontsize=8.5,
        )
    axes.set_yticks(range(len(ordered)), [_label(row) for row in ordered], fontsize=9)
    axes.set_ylim(-0.6, len(ordered) - 0.2)
    times = [row.median_s for row in rows] + [row.p99_s for row in rows]
    axes.set_xlim(min(times) / 6, max(times) * 1.6)
    _time_axis(axes, "x")


def horizon_figure(rows: Sequence[Row], problem: str = HORIZON_PROBLEM) -> Figure:
    """Draw the median time of every contender over the horizon, with its slope.

    One panel without bounds, one with bounds where there are such rows.
    """
    drawn = [row for row in rows if row.problem == problem and row.mode in (ONE_PASS, CONVERGED)]
    kinds = sorted({row.bounds for row in drawn}) or [False]
    names = {name: i for i, name in enumerate(dict.fromkeys(_label(row) for row in drawn))}
    figure, axes = plt.subplots(
        1, len(kinds), figsize=(7 * len(kinds), 6), layout="constrained", squeeze=False, sharey=True
    )
    for axis, bounds in zip(axes[0], kinds, strict=True):
        _draw_horizons(axis, [row for row in drawn if row.bounds == bounds], names)
        axis.set_title(
            f"{problem}{', bounded' if bounds else ''}: time over the horizon; slope 1 is linear",
            fontsize=10,
        )
    axes[0, 0].set_ylabel("median time per window")
    return figure


def _draw_horizons(axes: Axes, rows: Sequence[Row], colors: Mapping[str, int]) -> None:
    curves: dict[str, list[Row]] = {}
    for row in rows:
        curves.setdefault(_label(row), []).append(row)
    for name, found in curves.items():
        found.sort(key=lambda row: row.horizon)
        N, time_s = np.array([(row.horizon, row.median_s) for row in found]).T
        slope = f": slope {np.polyfit(np.log(N), np.log(time_s), 1)[0]:.2f}" if len(N) > 1 else ""
        marker, color = MODE_STYLES[found[0].mode]["marker"], f"C{colors[name]}"
        axes.loglog(N, time_s, marker=marker, markersize=5, color=color, label=name + slope)
    horizons = sorted({row.horizon for row in rows})
    axes.set_xticks(horizons, [str(N) for N in horizons])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel("horizon N / intervals of 10 ms")
    _time_axis(axes, "y")
    if curves:
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, fontsize=8)


def _label(row: Row) -> str:
    """Return what stands beside a row's time; the horizon too where a panel has several."""
    if row.mode in REUSE_MODES:
        return f"{row.contender}, N = {row.horizon}, {row.mode.removeprefix('stream, ')}"
    return f"{row.contender}, {row.mode}"


def _time_axis(axes: Axes, which: str) -> None:
    """Make an axis of times logarithmic, with units on its ticks."""
    getattr(axes, f"set_{which}scale")("log")
    axis = getattr(axes, f"{which}axis")
    axis.set_major_locator(LogLocator())
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda time_s, _: in_unit(time_s)))
    axes.grid(alpha=0.3)
