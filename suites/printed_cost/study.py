"""The work behind ``pen-mhe printed-cost``: what the paper's errors cost, over speed."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter

from benchmark.console import console, print_table
from benchmark.runner.kept import Jobs, kept_results
from estimation.output_file import whole_file
from estimation.output_folder import check_folder
from pen_mhe.errors import NOT_OBSERVABLE
from pen_mhe.figures import save
from suites.printed_cost.run import (
    AS_PRINTED,
    CONFIGURATIONS,
    DURATION_S,
    MOTION,
    RIGID_BODY,
    SEEDS,
    SPEEDS,
    cost_row,
    cost_tasks,
)

STYLES: Mapping[str, Mapping[str, Any]] = {
    RIGID_BODY: {"color": "black", "marker": "o"},
    "E2 only": {"color": "C0", "marker": "s"},
    "E3 only": {"color": "C1", "marker": "^"},
    "E4 only": {"color": "C2", "marker": "x", "linestyle": "--"},
    AS_PRINTED: {"color": "C3", "marker": "D"},
}
"""A line of the figure by model; dashes where it lies on the rigid body's."""

MEANING: Mapping[str, str] = {
    "E2 only": "E2: inverse matrix in (5)",
    "E3 only": "E3: sign of x in (6)",
    "E4 only": "E4: no Coriolis term in (6)",
    AS_PRINTED: "as printed: all three",
}
QUANTITIES: Mapping[str, str] = {
    "tip_mm": "tip / mm",
    "elevation_deg": "elevation / °",
    "azimuth_deg": "azimuth / °",
}
SPEED_LABEL = "RMS tip speed / (mm/s)"


def run_printed_cost(
    output: Path,
    speeds: Sequence[float] = SPEEDS,
    seeds: Sequence[int] = SEEDS,
    duration_s: float = DURATION_S,
) -> None:
    """Run every model at every speed, print the table, write ``printed_cost.csv`` and ``.png``.

    Parameters
    ----------
    output : folder to write to
    speeds, seeds, duration_s : of `suites.printed_cost.run.cost_tasks`
    """
    check_folder(output)
    tasks = cost_tasks(speeds, seeds, duration_s)
    table = pd.DataFrame(kept_results("printed-cost", cost_row, tasks, output, jobs=Jobs()))
    with whole_file(output / "printed_cost.csv") as file:
        table.to_csv(file, index=False, na_rep=NOT_OBSERVABLE)
    save(printed_cost_figure(table), output / "printed_cost.png")
    columns, rows = _readable(table)
    title = (
        f"RMS errors of the EKF, mean ± spread over {len(seeds)} seeds of '{MOTION}', "
        f"{duration_s:g} s each"
    )
    print_table(title, columns, rows)
    console.print(
        f"\nPython {platform.python_version()}, casadi {version('casadi')}, "
        f"pen-mhe {version('pen-mhe')}; table and figure in {output}"
    )


def _readable(table: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    columns = ["speed", "tip mm/s", "sensors", "model", "accel error m/s²", *QUANTITIES.values()]
    rows = []
    for row in table.to_dict("records"):
        start = [f"{row['speed']:g}", f"{row['tip_speed_mm_s']:.0f}", row["sensors"], row["model"]]
        errors = [_with_spread(row[key], row[f"{key}_spread"]) for key in QUANTITIES]
        rows.append([*start, f"{row['accel_error_m_s2']:.2g}", *errors])
    return columns, rows


def _with_spread(mean: float, spread: float) -> str:
    return NOT_OBSERVABLE if pd.isna(mean) else f"{mean:.3f} ± {spread:.3f}"


def printed_cost_figure(table: pd.DataFrame) -> Figure:
    """Draw the error terms over speed, and the EKF's errors by model.

    Parameters
    ----------
    table : rows of `suites.printed_cost.run.cost_row`
    """
    figure = plt.figure(figsize=(12, 6.2), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=(1.25, 1, 1))
    _draw_terms(figure.add_subplot(grid[:, 0]), table)
    camera, no_camera = CONFIGURATIONS
    panels = ((camera, "tip_mm"), (camera, "azimuth_deg"), (camera, "elevation_deg"))
    for place, (sensors, column) in zip(
        ((0, 1), (0, 2), (1, 1), (1, 2)), (*panels, (no_camera, "elevation_deg")), strict=True
    ):
        axes = figure.add_subplot(grid[place])
        _draw_errors(axes, table[table["sensors"] == sensors], column)
        axes.set_title(f"EKF, {sensors}", fontsize=10)
    figure.axes[-1].legend(fontsize=8, loc="upper left", title="its model", title_fontsize=8)
    figure.suptitle(
        f"Accelerometer and gyroscope; '{MOTION}' played {table['speed'].min():g} to "
        f"{table['speed'].max():g} times as fast; bars: spread over seeds",
        fontsize=11,
    )
    return figure


def _draw_terms(axes: Axes, table: pd.DataFrame) -> None:
    one = table[table["sensors"] == next(iter(CONFIGURATIONS))]
    for model, meaning in MEANING.items():
        rows = one[one["model"] == model]
        style = {**STYLES[model], "linestyle": "-"}
        axes.plot(rows["tip_speed_mm_s"], rows["accel_error_m_s2"], label=meaning, **style)
    noise = float(one["accel_noise_m_s2"].iloc[0])
    axes.axhline(noise, color="0.4", linestyle=":", label="sensor noise, std of one axis")
    axes.set_yscale("log")
    axes.set_ylabel("RMS error of the accelerometer's equation / (m/s²)")
    axes.set_title("printed accelerometer minus rigid body's", fontsize=10)
    axes.legend(fontsize=8, loc="upper left")
    _speed_axis(axes, one)


def _draw_errors(axes: Axes, table: pd.DataFrame, column: str) -> None:
    # Side by side, so that bars do not hide each other.
    for model, aside in zip(STYLES, (0.94, 0.97, 1.0, 1.03, 1.06), strict=True):
        style, rows = STYLES[model], table[table["model"] == model]
        axes.errorbar(
            aside * rows["tip_speed_mm_s"],
            rows[column],
            rows[f"{column}_spread"],
            label=model,
            **{"markersize": 4, "capsize": 2, "linewidth": 1.2, "elinewidth": 0.7, **style},
        )
    axes.set_ylim(bottom=0)
    axes.set_ylabel(f"RMS error of {QUANTITIES[column]}")
    _speed_axis(axes, table)


def _speed_axis(axes: Axes, table: pd.DataFrame) -> None:
    axes.set_xscale("log")
    axes.set_xlabel(SPEED_LABEL)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_locator(NullLocator())
    speeds = table["tip_speed_mm_s"]
    axes.set_xlim(0.8 * speeds.min(), 1.25 * speeds.max())
    axes.grid(alpha=0.3)
