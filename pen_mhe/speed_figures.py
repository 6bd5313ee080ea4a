"""Figures of the suite speed: time per window by contender, and over the horizon."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from benchmark.speed.contender import BATCH, CONVERGED, ONE_PASS, PASS_CALL
from benchmark.speed.rows import Row

MODE_STYLES: Mapping[str, Mapping[str, Any]] = {
    ONE_PASS: {"color": "C0", "marker": "o"},
    PASS_CALL: {"color": "C0", "marker": "v"},
    CONVERGED: {"color": "C1", "marker": "s"},
    BATCH: {"color": "C2", "marker": "D"},
}
WINDOW_MODES = (ONE_PASS, PASS_CALL, CONVERGED)
OTHER_MODE: Mapping[str, Any] = {"color": "C3", "marker": "^"}
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
TIME_LABEL = "time per window: median, to 99 % quantile"
HORIZON_PROBLEM = "pen15"


def in_unit(time_s: float) -> str:
    """Return a time with a unit that leaves 1 to 3 digits in front: ``46 µs``."""
    for scale, unit in UNITS:
        if time_s >= scale * (1 - 1e-9):
            return f"{time_s / scale:.3g} {unit}"
    return f"{time_s / UNITS[-1][0]:.3g} {UNITS[-1][1]}"


def contender_figure(rows: Sequence[Row]) -> Figure:
    """Draw one panel per problem: contenders below each other, time on a log axis."""
    by_problem: dict[tuple[str, int], list[Row]] = {}
    for row in rows:
        if row.mode in WINDOW_MODES:
            by_problem.setdefault((row.problem, row.horizon), []).append(row)
    streams = [row for row in rows if row.mode not in WINDOW_MODES]
    panels = [(f"{problem}, N = {N}", found) for (problem, N), found in by_problem.items()]
    if streams:
        panels.append((f"{streams[0].problem}, stream: time per sample", streams))
    columns = min(3, len(panels))
    lines = -(-len(panels) // columns)
    figure, axes = plt.subplots(
        lines, columns, figsize=(5.2 * columns, 3.4 * lines), layout="constrained", squeeze=False
    )
    for axis, (title, found) in zip(axes.flat, panels, strict=False):
        _draw_times(axis, found)
        axis.set_title(title, fontsize=10)
    for axis in axes.flat[len(panels) :]:
        axis.set_axis_off()
    for axis in axes[-1]:
        axis.set_xlabel(TIME_LABEL)
    return figure


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
            fontsize=7,
        )
    axes.set_yticks(range(len(ordered)), [f"{r.contender}, {r.mode}" for r in ordered], fontsize=8)
    axes.set_ylim(-0.6, len(ordered) - 0.2)
    times = [row.median_s for row in rows] + [row.p99_s for row in rows]
    axes.set_xlim(min(times) / 6, max(times) * 1.6)
    _time_axis(axes, "x")


def horizon_figure(rows: Sequence[Row], problem: str = HORIZON_PROBLEM) -> Figure:
    """Draw the median time of every contender over the horizon, with its slope."""
    figure, axes = plt.subplots(figsize=(7, 5), layout="constrained")
    curves: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        if row.problem == problem and row.mode in (ONE_PASS, CONVERGED):
            curves.setdefault((row.contender, row.mode), []).append(row)
    for i, ((contender, mode), found) in enumerate(curves.items()):
        found.sort(key=lambda row: row.horizon)
        N, time_s = np.array([(row.horizon, row.median_s) for row in found]).T
        label = f"{contender}, {mode}"
        if len(N) > 1:
            label += f": slope {np.polyfit(np.log(N), np.log(time_s), 1)[0]:.2f}"
        marker = MODE_STYLES[mode]["marker"]
        axes.loglog(N, time_s, marker=marker, markersize=5, color=f"C{i}", label=label)
    horizons = sorted({row.horizon for found in curves.values() for row in found})
    axes.set_xticks(horizons, [str(N) for N in horizons])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel("horizon N / intervals of 10 ms")
    axes.set_ylabel("median time per window")
    axes.set_title(f"{problem}: time over the horizon; slope 1 is linear", fontsize=10)
    _time_axis(axes, "y")
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    return figure


def _time_axis(axes: Axes, which: str) -> None:
    """Make an axis of times logarithmic, with units on its ticks."""
    getattr(axes, f"set_{which}scale")("log")
    axis = getattr(axes, f"{which}axis")
    axis.set_major_locator(LogLocator())
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda time_s, _: in_unit(time_s)))
    axes.grid(alpha=0.3)
