"""The figures of the suite `pen` about the aim of [Pen] and about its equations as printed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmark.configurations import CONFIGURATIONS
from benchmark.figures.figure import Figure, Line, Panel
from benchmark.tasks.results import Results
from models.arrays import Array
from suites.pen.known_start import AT_S, BEGIN, BEGIN_S, FREE, NO_SPIN, SENSORS
from suites.pen.pen_cases import (
    ON_AXIS,
    ON_AXIS_BEGIN,
    PEN_CASES,
    PRINTED,
    PRINTED_BEGIN,
    WITH_IPOPT_S,
)
from suites.pen_quantities import at_time

NAME = "pen"
AIMS = (("tip", "mm"), ("azimuth", "deg"), ("elevation", "deg"))
OVER_TIME = (("ekf", None), ("mhe-rti", None), ("mhe-ipopt", BEGIN))
"""Estimator, and the case in the place of the pen's own that it runs on."""

PRINTED_SENSORS = "accel+gyro+camera"
PLACES = (
    *((ON_AXIS, PRINTED, name) for name in ("ekf", "mhe-rti")),
    *((ON_AXIS_BEGIN, PRINTED_BEGIN, name) for name in ("ekf", "mhe-rti", "mhe", "mhe-ipopt")),
)
"""Rigid body, as printed, estimator: along the x axis."""


def known_start(results: Results) -> Figure:
    """Return errors and claims over time from a known start."""
    panels = []
    for case, pen in ((NO_SPIN, "no-spin pen"), (FREE, "free pen")):
        for quantity, unit in AIMS:
            lines: list[Line] = []
            for estimator, begin in OVER_TIME:
                if begin is None or case == NO_SPIN:
                    lines += _grown(results, begin or case, estimator, quantity)
            label = f"{quantity} error ({unit})"
            title = f"{pen}: {quantity}"
            panels.append(
                Panel(title, "time from the start (s)", label, lines, x_log=True, y_log=True)
            )
    return Figure(
        "pen-known-start",
        "From a known start: how long are tip and attitude known?",
        "[Pen]'s stated aim. Accelerometer and gyroscope alone, nothing else says where the pen "
        "is; pose and rates are known at the start (0.1 mm, 0.1 deg). RMS error over the seeds, "
        "dashed what the estimator claims. A bias of 20 mg that no start tells takes the tip away "
        "with the square of the time, until the hand's speed bounds it; gravity holds the "
        "elevation to what the bias leaves, nothing holds the azimuth. "
        f"mhe-ipopt solves the first {BEGIN_S:g} s of the pen that cannot spin. The estimators' "
        "lines lie on each other.",
        panels,
        columns=len(AIMS),
    )


def _grown(results: Results, case: str, estimator: str, quantity: str) -> list[Line]:
    rows = results.select(suite=NAME, case=case, sensors=SENSORS, estimator=estimator)
    found = []
    for at in AT_S:
        of = rows[rows["quantity"] == at_time(quantity, at)]
        if len(of):
            squares = (of[["rmse", "claimed"]] ** 2).mean() ** 0.5
            found.append((at, squares["rmse"], squares["claimed"]))
    if not found:
        return []
    x, errors, claims = np.array(found, dtype=float).T
    return [
        Line(estimator, x, errors),
        Line(f"claimed by {estimator}", x, claims, style="dashed"),
    ]


def printed(results: Results) -> Figure:
    """Return (9) as printed beside the rigid body, estimator by estimator."""
    panels = []
    places = ", ".join(
        f"{i} {name} {PEN_CASES[case].duration_s:g} s"
        for i, (case, _, name) in enumerate(PLACES, start=1)
    )
    for quantity, unit in (("tip", "mm"), ("elevation", "deg")):
        lines = [
            _by_place(results, name, column, quantity)
            for column, name in enumerate(("rigid body", "(9) as printed"))
        ]
        panels.append(
            Panel(
                f"{CONFIGURATIONS[PRINTED_SENSORS].label}: {quantity}",
                places,
                f"{quantity} RMSE ({unit})",
                [line for line in lines if line is not None],
                y_log=True,
            )
        )
    return Figure(
        "pen-printed",
        "What the errors of (9) as printed cost",
        "A pen that cannot spin, sensors on its axis: the rigid body and (9) as printed, its axes "
        "signed so that both agree at rest. Mean over the seeds, smallest and largest. "
        f"{WITH_IPOPT_S:g} s are what IPOPT solves too. The camera's frames are weighed less the "
        "further they are from what is predicted, by the EKF's prediction before the window's. On "
        "the turntable (9) is (12): its errors are in terms that (12) leaves out. Without a camera "
        "they do not show: the tip's free acceleration takes them up.",
        panels,
    )


def _by_place(results: Results, name: str, column: int, quantity: str) -> Line | None:
    found: list[tuple[float, ...]] = []
    for place, row in enumerate(PLACES, start=1):
        errors = results.select(
            suite=NAME,
            case=row[column],
            sensors=PRINTED_SENSORS,
            quantity=quantity,
            estimator=row[2],
        )["rmse"]
        if len(errors):
            found.append((place, errors.mean(), errors.min(), errors.max()))
    if not found:
        return None
    x, y, low, high = _columns(found)
    return Line(name, x, y, None, low, high, "points")


def _columns(rows: Sequence[tuple[float, ...]]) -> Array:
    return np.array(rows, dtype=float).T
