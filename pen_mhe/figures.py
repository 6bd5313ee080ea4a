"""Figures of estimates: path, angles with their uncertainty, step times."""

from __future__ import annotations

import io
from collections.abc import Collection
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from estimation.estimate import EstimateHistory
from estimation.history_plot import new_figure
from estimation.output_file import write_whole
from estimation.recording import Truth
from estimation.watch.shades import shade
from recordings.ink import InkMatch

ANGLES = (("azimuth_rad", "azimuth"), ("elevation_rad", "elevation"), ("spin_rad", "spin"))
PATH = {"tip_x_m", "tip_y_m"}
UNSEEN_STYLE: dict[str, Any] = {"color": "0.55", "linewidth": 0.8, "linestyle": "--"}
NOT_SEEN = "not observable: only how it changes"
TRUTH_STYLE: dict[str, Any] = {"color": "black", "linewidth": 1.0, "label": "truth"}


def save(figure: Figure, path: Path) -> None:
    """Write a figure whole, and close it."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format=path.suffix[1:], dpi=150)
    plt.close(figure)
    write_whole(path, drawn.getvalue())


def estimate_figure(
    history: EstimateHistory,
    ink: InkMatch | None = None,
    *,
    truth: Truth | None = None,
    samples: int | None = None,
    unseen: Collection[str] = (),
) -> Figure:
    """Draw the tip's path (over the ink, where there is a scan), the angles and the step times.

    Spans in which a watched run was lost or flagged a sensor are shaded.

    Parameters
    ----------
    samples : of the run, where the history has only some of them, evenly spread
    unseen : quantities that no reading shows: a path is then not drawn, an angle as one of which
        only changes are known
    """
    angles = [pair for pair in ANGLES if pair[0] in history.names]
    figure = new_figure(11, 6.5)
    has_path = ink is not None or not PATH & set(unseen)
    grid = figure.add_gridspec(
        len(angles) + 1, 1 + has_path, width_ratios=(3, 2) if has_path else None
    )
    if has_path:
        _draw_path(figure.add_subplot(grid[:, 0]), history, ink, truth)
    for row, (state, label) in enumerate(angles):
        axes = figure.add_subplot(grid[row, -1])
        _draw_angle(axes, history, state, truth, is_seen=state not in unseen)
        shade(axes, [history])
        axes.set_ylabel(f"{label} (deg)")
        axes.tick_params(labelbottom=False)
        if row == 0 and truth is not None:
            axes.legend(loc="upper right", fontsize=8, ncols=3)
    steps = figure.add_subplot(grid[len(angles), -1])
    steps.semilogy(history.time_s, history.step_time_s * 1e3, ".", markersize=2)
    shade(steps, [history])
    steps.set_xlabel("time (s)")
    steps.set_ylabel("step (ms)")
    steps.yaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    steps.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    steps.yaxis.set_minor_formatter(NullFormatter())
    if handles := steps.get_legend_handles_labels()[0]:
        steps.legend(handles=handles, loc="upper right", fontsize=8)
    drawn = f", {len(history)} of them drawn" if samples not in (None, len(history)) else ""
    title = f"{history.estimator}: {samples or len(history)} samples{drawn}"
    if not has_path:
        title += "; the tip is not observable and not drawn: no reading shows where the pen is"
    figure.suptitle(title, fontsize=11)
    return figure


def _draw_path(
    axes: Axes, history: EstimateHistory, ink: InkMatch | None, truth: Truth | None
) -> None:
    if ink is not None:
        axes.plot(*ink.ink_mm.T, ".", color="0.8", markersize=1, label="scanned ink")
        axes.plot(
            *ink.path_mm.T,
            ".",
            markersize=1.5,
            label=f"tip, mean distance {ink.mean_distance_mm:.3f} mm",
        )
        axes.set_title("tip while it presses, shifted onto the ink", fontsize=10)
    else:
        x, y = history.column("tip_x_m") * 1e3, history.column("tip_y_m") * 1e3
        axes.plot(x, y, label="estimate")
        if truth is not None and {"tip_x_m", "tip_y_m"} <= set(truth.names):
            columns = [truth.names.index(name) for name in ("tip_x_m", "tip_y_m")]
            axes.plot(*(truth.values[:, columns].T * 1e3), **TRUTH_STYLE)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    axes.legend(loc="upper right", markerscale=6)


def _draw_angle(
    axes: Axes, history: EstimateHistory, state: str, truth: Truth | None, *, is_seen: bool
) -> None:
    value = np.degrees(np.unwrap(history.column(state)))
    band = 2 * np.degrees(history.std_of(state))
    # The first instants are as wide as the prior and would hide the rest.
    shown = [value[len(value) // 10 :]]
    if is_seen:
        axes.fill_between(history.time_s, value - band, value + band, alpha=0.3, label="± 2 σ")
        axes.plot(history.time_s, value, linewidth=0.8, label="estimate")
    else:
        axes.plot(history.time_s, value, **UNSEEN_STYLE)
        axes.set_title(NOT_SEEN, fontsize=8, loc="left", pad=2)
    if truth is not None and state in truth.names:
        true = np.degrees(truth.values[:, truth.names.index(state)])
        known = np.isfinite(true)
        if known.any():
            true[known] = np.unwrap(true[known], period=360)
            last = np.flatnonzero(known)[-1]
            near = np.interp(truth.time_s[last], history.time_s, value)
            true += 360 * np.round((near - true[last]) / 360)  # whole turns say nothing
            axes.plot(truth.time_s, true, **TRUTH_STYLE)
            shown.append(true[known])
    low, high = min(map(np.nanmin, shown)), max(map(np.nanmax, shown))
    margin = 5 + 0.1 * (high - low)
    axes.set_ylim(low - margin, high + margin)
