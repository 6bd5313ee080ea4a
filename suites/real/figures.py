"""The figures of the suite `real`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel
from benchmark.tasks.results import Results
from suites.real.cases import (
    BEST,
    CAMERA_ALONE,
    CAUSAL,
    INERTIAL,
    LAG,
    NO_CAMERA,
    UNBIASED,
    WITH_CAMERA,
    WITHOUT,
    ZERO_DELAY,
    RealCase,
)
from suites.real.ingredients import INGREDIENTS

NAME = "real"
CAMERA = "camera (not used)"
LOST_MM = 100.0
"""A run that is farther off is lost: it has no place in a figure."""

DPOINT: Mapping[str, Mapping[int, float]] = MappingProxyType(
    {
        "D-POINT, had arrived": {
            30: 0.162, 15: 0.185, 10: 0.216, 6: 0.285, 5: 0.328, 3: 0.589,
        },
        f"D-POINT, {LAG} samples later": {
            30: 0.122, 15: 0.125, 10: 0.134, 6: 0.158, 5: 0.181, 3: 0.341,
        },
    }
)  # fmt: skip
"""Mean ink distance, mm, of D-POINT's own filter (its EKF, smoothed, 22 states) by camera rate:
its code on the same recording, all phases, the same measure. Not run here."""


@dataclass(frozen=True)
class RateLine:
    """A line over the camera's rate: its name, and which results it shows."""

    name: str
    cases: Mapping[str, RealCase]
    sensors: str
    estimator: str
    quantity: str


def figures(results: Results) -> Sequence[Figure]:
    """Draw what there is: errors over the camera's rate, paths, elevation without a camera."""
    drawn = [_over_rate(results), _ingredients(results), _paths(results), _elevation(results)]
    return [figure for figure in drawn if any(panel.lines for panel in figure.panels)]


def _over_rate(results: Results) -> Figure:
    by_sensors = [
        RateLine(sensors, CAUSAL, sensors, "ekf", "ink")
        for sensors in WITH_CAMERA
        if sensors != CAMERA_ALONE
    ]
    by_time = [
        RateLine("ekf", CAUSAL, BEST, "ekf", "ink"),
        RateLine("mhe-rti", CAUSAL, BEST, "mhe-rti", "ink"),
        RateLine(f"mhe-rti, {LAG} samples later", CAUSAL, BEST, "mhe-rti", f"ink_{LAG}"),
        RateLine("ekf, zero delay", ZERO_DELAY, BEST, "ekf", "ink"),
    ]
    frames = [replace(row, quantity="left_out_position") for row in by_sensors]
    panels = []
    for title, label, rows, more in (
        ("ink by what an estimate knows", "ink distance (mm)", by_time, DPOINT),
        ("ink by sensors, from what had arrived", "ink distance (mm)", by_sensors, {}),
        ("frames left out by sensors", "left-out position (mm)", frames, {}),
    ):
        lines = [*_lines(results, rows), *_published(more)]
        drawn = lines if any(line.style == "line" for line in lines) else []
        panels.append(Panel(title, "camera rate (Hz)", label, drawn, x_log=True, y_log=True))
    return Figure(
        "real-camera-rate",
        "What a slower camera costs, and what waiting brings",
        f"Mean over the phases of the thinning, with the smallest and the largest; {BEST} where no "
        "sensors are named, EKF where no estimator is. Dashed: D-POINT's own filter on the same "
        "recording, by the same measure. Left out: RMS against frames that the estimator was not "
        f"given. A run more than {LOST_MM:g} mm off is lost and not drawn.",
        panels,
        columns=3,
    )


def _lines(results: Results, rows: Sequence[RateLine]) -> list[Line]:
    lines = []
    for row in rows:
        found = results.select(sensors=row.sensors, estimator=row.estimator, quantity=row.quantity)
        kept = found[found["rmse"] <= LOST_MM]
        by_case = kept.groupby("case")["rmse"].agg(["mean", "min", "max"])
        known = [(case.rate_hz, name) for name, case in row.cases.items() if name in by_case.index]
        if known:
            mean, low, high = (
                np.array([by_case.loc[name, column] for _, name in known], dtype=float)
                for column in ("mean", "min", "max")
            )
            x = np.array([rate for rate, _ in known], dtype=float)
            lines.append(Line(row.name, x, mean, None, low, high))
    return lines


def _published(figures_mm: Mapping[str, Mapping[int, float]]) -> list[Line]:
    return [
        Line(name, np.array([*of], dtype=float), np.array([*of.values()]), style="dashed")
        for name, of in figures_mm.items()
    ]


def _ingredients(results: Results) -> Figure:
    """Draw how much worse the ink is without each thing that the pen file knows."""
    panels = []
    for estimator in ("ekf", "mhe-rti"):
        rows = results.select(sensors=BEST, estimator=estimator, quantity="ink")
        of_case = rows.set_index(["case", "seed"])["rmse"]
        lines = []
        for name in INGREDIENTS:
            ratios = {}
            for case, row in WITHOUT.items():
                whole = f"causal, {row.rate_hz} Hz"
                if row.without == name and case in of_case.index and whole in of_case.index:
                    both = of_case[case] / of_case[whole]
                    ratios[float(row.rate_hz)] = 100 * (float(both.dropna().mean()) - 1)
            if ratios:
                lines.append(Line(f"no {name}", np.array([*ratios]), np.array([*ratios.values()])))
        panels.append(
            Panel(estimator, "camera rate (Hz)", "ink distance more by (%)", lines, x_log=True)
        )
    return Figure(
        "real-ingredients",
        "What each thing that the pen file knows is worth",
        "Mean ink distance from what had arrived without one of them, against the whole file, on "
        "the same phases.",
        panels,
        columns=2,
    )


def _paths(results: Results) -> Figure:
    panels = []
    for case in ("zero delay, 30 Hz", "zero delay, 15 Hz", "zero delay, 10 Hz"):
        lines = []
        for sensors in (CAMERA_ALONE, INERTIAL):
            x, y = (
                results.lines(
                    sensors,
                    suite=NAME,
                    case=case,
                    sensors=sensors,
                    estimator="ekf",
                    quantity=quantity,
                )
                for quantity in ("tip_x", "tip_y")
            )
            if x is not None and y is not None:
                lines.append(Line(sensors, x.y, y.y))
        panels.append(Panel(case, "x (mm)", "y (mm)", lines, equal=True))
    return Figure(
        "real-paths",
        "The tip on the paper, with and without inertial sensors",
        "EKF, first 8 s, phase 0; strokes and the ways between them. Between frames, a camera "
        "alone can only go on as before.",
        panels,
        columns=3,
    )


def _elevation(results: Results) -> Figure:
    panels = []
    for case, sensors in (
        (NO_CAMERA, "accel+gyro"),
        (UNBIASED, "accel+gyro"),
        (NO_CAMERA, "accel"),
        (NO_CAMERA, "gyro"),
    ):
        lines = []
        for name in (CAMERA, "ekf", "mhe-rti"):
            line = results.lines(
                name,
                name == CAMERA,
                suite=NAME,
                case=case,
                sensors=sensors,
                estimator="ekf" if name == CAMERA else name,
                quantity="elevation",
            )
            if line is not None:
                lines.append(replace(line, style="dashed") if name == CAMERA else line)
        panels.append(Panel(f"{sensors}, {case}", "time (s)", "elevation (deg)", lines))
    return Figure(
        "real-elevation",
        "Elevation without a camera",
        "With ±2σ as claimed, against the camera, which takes no part in the estimate.",
        panels,
        columns=1,
    )
