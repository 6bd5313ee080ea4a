"""The figures of the suite `pen`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from benchmark.configurations import CONFIGURATIONS, TURNTABLE_CONFIGURATIONS
from benchmark.figures.figure import TRUTH, Figure, Line, Panel
from benchmark.tasks.results import Results
from benchmark.tasks.task import OK
from suites.pen.aim_figures import known_start, printed
from suites.pen.pen_cases import (
    PEN_CASES,
    PEN_ESTIMATORS,
    REFERENCE,
    SPIN_IGNORED,
    WITHOUT_SPIN,
)
from suites.pen.pen_run import SHOWN_SENSORS
from suites.pen.stroke_figures import raw_readings, told_tolerances
from suites.pen.table_run import START_ERRORS_DEG, STROKES, TABLE_ESTIMATORS
from suites.pen.told_tolerance import SHOWN
from suites.pen_quantities import SETTLING_S

NAME = "pen"
TIME = "time (s)"
QUANTITIES = (
    ("tilt_phi", "tilt φ", "deg"),
    ("tilt_theta", "tilt θ", "deg"),
    ("tilt_phi_rate", "rate of φ", "deg/s"),
    ("tilt_theta_rate", "rate of θ", "deg/s"),
)


def figures(results: Results) -> Sequence[Figure]:
    """Draw what there is: the free pen, the pen that cannot spin, the turntable."""
    drawn = [
        _elevation(results),
        _paths(results),
        _spin_ignored(results),
        _speeds(results),
        printed(results),
        known_start(results),
        raw_readings(results),
        *_strokes(results),
        told_tolerances(results),
        _starts(results),
        _by_stroke(results),
    ]
    return [figure for figure in drawn if any(panel.lines for panel in figure.panels)]


def _strokes(results: Results) -> Iterator[Figure]:
    """Yield what figure 4 of [Pen] shows of each compound stroke: angles, rates, three choices."""
    for key, case in zip(("pen-figure-4-vertical", "pen-figure-4"), SHOWN, strict=True):
        stroke = case.partition(": ")[2]
        panels = [
            Panel(
                f"{TURNTABLE_CONFIGURATIONS[sensors].label}: {label}",
                TIME,
                f"{label} ({unit})",
                _over_time(results, ("ekf", "mhe"), case=case, sensors=sensors, quantity=quantity),
            )
            for quantity, label, unit in QUANTITIES
            for sensors in TURNTABLE_CONFIGURATIONS
        ]
        yield Figure(
            key,
            f"{stroke} on the turntable",
            "After figure 4 of [Pen]: angles and rates of the stroke by choice of sensors, "
            "seed 0, with ±2σ as claimed. The start is known to 2 deg. With the accelerometer "
            "alone the rates lag at corners; with both they follow in some tenths of a second. "
            "With the gyroscope alone the angles keep the error of the start, and get new ones at "
            "corners: its reading φ̇ cosθ changes, and the filter finds a part of that in θ.",
            panels,
            columns=3,
        )


def _over_time(
    results: Results, estimators: Sequence[str], case: str, sensors: str, quantity: str
) -> list[Line]:
    """Return a quantity of seed 0 by estimator, and its truth."""

    def line(name: str, estimator: str) -> Line | None:
        return results.lines(
            name,
            name == TRUTH,
            suite=NAME,
            case=case,
            sensors=sensors,
            estimator=estimator,
            quantity=quantity,
        )

    lines = [found for name in estimators if (found := line(name, name)) is not None]
    if lines and (truth := line(TRUTH, lines[0].name)) is not None:
        lines.insert(0, truth)
    return lines


def _starts(results: Results) -> Figure:
    """Return how a run ends over how wrong its start was, and how many end in the mirror."""
    panels = []
    for sensors, configuration in TURNTABLE_CONFIGURATIONS.items():
        lines = [
            _over_start(results, sensors, estimator, mirror=False) for estimator in TABLE_ESTIMATORS
        ]
        panels.append(
            Panel(
                f"{configuration.label}: runs at the truth",
                "error of the start (deg)",
                "tilt RMSE (deg)",
                [line for line in lines if line is not None],
                y_log=True,
            )
        )
    for sensors, configuration in TURNTABLE_CONFIGURATIONS.items():
        lines = [
            _over_start(results, sensors, estimator, mirror=True) for estimator in TABLE_ESTIMATORS
        ]
        panels.append(
            Panel(
                f"{configuration.label}: mirror solutions",
                "error of the start (deg)",
                "runs in the mirror (%)",
                [line for line in lines if line is not None],
            )
        )
    return Figure(
        "pen-starts",
        "Wrong starts on the turntable",
        "Above: RMSE of both tilts over the last second, median over the runs that did not settle "
        "in the mirror solution, with the smallest and the largest. Below: how many did. An "
        "inertial sensor cannot tell the mirror from the truth, only the prior can.",
        panels,
        columns=3,
    )


def _over_start(results: Results, sensors: str, estimator: str, mirror: bool) -> Line | None:
    x, y, low, high = [], [], [], []
    for error in START_ERRORS_DEG:
        rows = results.select(
            suite=NAME,
            case=f"start {error} deg",
            sensors=sensors,
            estimator=estimator,
            quantity="tilts_last",
        )
        if mirror and len(rows):
            x.append(error)
            y.append(100 * float((rows["status"] == "mirror").mean()))
        elif not mirror and len(values := rows[rows["status"] == OK]["rmse"]):
            x.append(error)
            y.append(float(values.median()))
            low.append(float(values.min()))
            high.append(float(values.max()))
    if not x:
        return None
    ends = (None, None) if mirror else (np.array(low), np.array(high))
    return Line(estimator, np.array(x, dtype=float), np.array(y), None, *ends)


def _by_stroke(results: Results) -> Figure:
    """Return errors of angles and rates by stroke, for each choice of sensors."""
    strokes = [case for case in STROKES if ": " in case]
    panels = []
    for quantity, label, unit in (("tilts", "tilts", "deg"), ("tilt_rates", "rates", "deg/s")):
        for sensors, configuration in TURNTABLE_CONFIGURATIONS.items():
            lines = []
            for estimator in TABLE_ESTIMATORS:
                of = results.select(
                    suite=NAME, sensors=sensors, estimator=estimator, quantity=quantity
                )
                medians = of.groupby("case")["rmse"].median()
                known = [i for i, case in enumerate(strokes) if case in medians]
                if known:
                    y = np.array([medians[strokes[i]] for i in known], dtype=float)
                    lines.append(Line(estimator, np.array(known) + 1.0, y, style="points"))
            panels.append(
                Panel(
                    f"{configuration.label}: {label}",
                    "stroke",
                    f"RMSE of {label} ({unit})",
                    lines,
                    y_log=True,
                )
            )
    named = ", ".join(f"{i + 1} {case.partition(': ')[2]}" for i, case in enumerate(strokes))
    return Figure(
        "pen-by-stroke",
        "Ten strokes on the turntable",
        f"Median over the seeds. Strokes: {named}.",
        panels,
        columns=3,
    )


def _elevation(results: Results) -> Figure:
    panels = [
        Panel(
            CONFIGURATIONS[sensors].label,
            TIME,
            "elevation (deg)",
            _over_time(
                results, PEN_ESTIMATORS, case=REFERENCE, sensors=sensors, quantity="elevation"
            ),
        )
        for sensors in SHOWN_SENSORS[REFERENCE]
    ]
    return Figure(
        "pen-elevation",
        "Elevation of a writing pen that spins",
        "Six degrees of freedom, at the speed of handwriting; seed 0, ±2σ as claimed. The start "
        "is known to 20 deg. A gyroscope alone keeps the error of the start, and says so.",
        panels,
        columns=2,
    )


def _spin_ignored(results: Results) -> Figure:
    """Return a pen that spins, seen by the model that cannot and by the one that can."""
    names = {SPIN_IGNORED: "no spin believed", REFERENCE: "free"}
    panels = []
    for sensors in SHOWN_SENSORS[SPIN_IGNORED]:
        lines = []
        for case, name in ((SPIN_IGNORED, TRUTH), *names.items()):
            of = {"suite": NAME, "case": case, "sensors": sensors, "quantity": "elevation"}
            line = results.lines(name, name == TRUTH, **of, estimator="ekf")
            lines += [] if line is None else [line]
        panels.append(Panel(CONFIGURATIONS[sensors].label, TIME, "elevation (deg)", lines))
    return Figure(
        "pen-spin-ignored",
        "What believing in no spin costs",
        "The same pen that spins, estimated by an EKF whose pen cannot spin, and by one whose pen "
        "can; seed 0, ±2σ as claimed. Where a pen cannot spin, the ratio of two rates gives its "
        "elevation: on one that does, it is information that no sensor gave.",
        panels,
        columns=2,
    )


def _paths(results: Results) -> Figure:
    """Return the tip on the paper, where a camera sees it."""
    panels = []
    for sensors in SHOWN_SENSORS[REFERENCE]:
        lines = []
        for name in (TRUTH, *PEN_ESTIMATORS):
            estimator = PEN_ESTIMATORS[0] if name == TRUTH else name
            x, y = (
                results.lines(
                    name,
                    name == TRUTH,
                    suite=NAME,
                    case=REFERENCE,
                    sensors=sensors,
                    estimator=estimator,
                    quantity=quantity,
                )
                for quantity in ("tip_x", "tip_y")
            )
            if x is not None and y is not None:
                settled = x.x >= SETTLING_S
                lines.append(Line(name, x.y[settled], y.y[settled]))
        if lines:
            panels.append(
                Panel(CONFIGURATIONS[sensors].label, "x (mm)", "y (mm)", lines, equal=True)
            )
    return Figure(
        "pen-paths",
        "The tip on the paper",
        f"Path of the tip in the paper plane, seed 0, from {SETTLING_S:g} s on.",
        panels,
        columns=2,
    )


def _speeds(results: Results) -> Figure:
    """Return what neglecting the accelerations costs, over the speed of writing."""
    panels = []
    for quantity, unit in (("elevation", "deg"), ("rates", "deg/s")):
        lines = []
        for name, estimator in product(("rigid body", "accelerations neglected"), ("ekf", "mhe")):
            speeds = {
                case: row.assumed.speed
                for case, row in PEN_CASES.items()
                if case.startswith(f"{name}, speed ")
                or (case == WITHOUT_SPIN and name == "rigid body")
            }
            medians = (
                results.select(
                    suite=NAME,
                    case=list(speeds),
                    sensors="accel+gyro",
                    estimator=estimator,
                    quantity=quantity,
                )
                .groupby("case")["rmse"]
                .agg(["median", "min", "max"])
            )
            known = sorted((speeds[case], case) for case in medians.index)
            if known:
                median, low, high = (
                    np.array([medians.loc[case, column] for _, case in known], dtype=float)
                    for column in ("median", "min", "max")
                )
                x = np.array([speed for speed, _ in known])
                lines.append(Line(f"{name}, {estimator}", x, median, None, low, high))
        panels.append(
            Panel(
                quantity,
                "speed, handwriting = 1",
                f"RMSE of {quantity} ({unit})",
                lines,
                x_log=True,
                y_log=True,
            )
        )
    return Figure(
        "pen-speeds",
        "What the paper neglects, over speed",
        "A pen that cannot spin, accelerometer and gyroscope: the rigid body against an "
        "accelerometer that is taken for gravity alone, as on the turntable. Median, smallest "
        "and largest of the seeds. The EKF's errors are those of its start, 20 deg uncertain: the "
        "MHE's show what is neglected.",
        panels,
        columns=2,
    )
