"""The figures of the suite `real`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.figures.figure import Figure, Line, Panel
from benchmark.tasks.results import Results
from suites.real.dpoint_run import NO_CAMERA, RATES, UNBIASED, WITH_CAMERA

NAME = "real"
CAMERA = "camera (not used)"
MEASURES = (
    ("ink", "ink distance", "mm"),
    ("left_out_position", "left-out position", "mm"),
    ("left_out_orientation", "left-out orientation", "deg"),
)


def figures(results: Results) -> Sequence[Figure]:
    """Draw what there is: errors over the camera's rate, paths, elevation without a camera."""
    drawn = [_over_rate(results), _paths(results), _elevation(results)]
    return [figure for figure in drawn if any(panel.lines for panel in figure.panels)]


def _over_rate(results: Results) -> Figure:
    by_sensors = [
        Panel(
            f"{label} by sensors",
            "camera rate / Hz",
            f"{label} / {unit}",
            _lines(results, quantity, [(sensors, sensors, "ekf") for sensors in WITH_CAMERA]),
            x_log=True,
            y_log=True,
        )
        for quantity, label, unit in MEASURES
    ]
    by_estimator = [
        Panel(
            f"{label} by estimator",
            "camera rate / Hz",
            f"{label} / {unit}",
            _lines(
                results,
                quantity,
                [(name, "accel+gyro+camera", name) for name in BENCHMARK_ESTIMATORS],
            ),
            x_log=True,
            y_log=True,
        )
        for quantity, label, unit in MEASURES
    ]
    return Figure(
        "real-camera-rate",
        "What a slower camera costs",
        "Mean over the phases of the thinning, with the smallest and the largest. Above: by "
        "sensors, EKF; below: by estimator, accelerometer, gyroscope and camera. Left out: RMS "
        "error against the frames that the estimator was not given. Zero delay. A path that leaves "
        "the paper has no ink distance.",
        [*by_sensors, *by_estimator],
        columns=3,
    )


def _lines(results: Results, quantity: str, rows: Sequence[tuple[str, str, str]]) -> list[Line]:
    """Return a line per (name, sensors, estimator)."""
    lines = []
    for name, sensors, estimator in rows:
        found = results.select(sensors=sensors, estimator=estimator, quantity=quantity)
        by_case = found.groupby("case")["rmse"].agg(["mean", "min", "max"])
        known = [(rate, case) for case, rate in RATES.items() if case in by_case.index]
        if known:
            mean, low, high = (
                np.array([by_case.loc[case, column] for _, case in known], dtype=float)
                for column in ("mean", "min", "max")
            )
            x = np.array([rate for rate, _ in known], dtype=float)
            lines.append(Line(name, x, mean, None, low, high))
    return lines


def _paths(results: Results) -> Figure:
    panels = []
    for case in ("camera at 30 Hz", "camera at 15 Hz", "camera at 10 Hz"):
        lines = []
        for sensors in ("camera", "accel+gyro+camera"):
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
        panels.append(Panel(case, "x / mm", "y / mm", lines, equal=True))
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
        for name in (CAMERA, "ekf", "mhe"):
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
        panels.append(Panel(f"{sensors}, {case}", "time / s", "elevation / deg", lines))
    return Figure(
        "real-elevation",
        "Elevation without a camera",
        "With ±2σ as claimed, against the camera, which takes no part in the estimate.",
        panels,
        columns=1,
    )
