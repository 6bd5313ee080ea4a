"""The figures of the suite `pen` about single strokes: raw readings, and the tolerance told."""

from __future__ import annotations

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel
from benchmark.tasks.results import Results
from models.turntable import paper_turntable
from suites.pen.raw_readings import CHANNELS, RAW_SHOWN
from suites.pen.told_tolerance import SHOWN, SWEEP

NAME, TIME = "pen", "time (s)"


def raw_readings(results: Results) -> Figure:
    """Return what the sensors read along both compound strokes, figure 3 of [Pen]."""
    sensors, estimator = RAW_SHOWN
    panels = []
    for sensor, (axes, unit, _) in CHANNELS.items():
        for case in SHOWN:
            lines = [
                results.lines(
                    f"{sensor} {axis}",
                    suite=NAME,
                    case=case,
                    sensors=sensors,
                    estimator=estimator,
                    quantity=f"raw {sensor} {axis}",
                )
                for axis in axes
            ]
            panels.append(
                Panel(
                    f"{case.partition(': ')[2]}: {sensor}",
                    TIME,
                    f"{sensor} ({unit})",
                    [line for line in lines if line is not None],
                )
            )
    return Figure(
        "pen-figure-3",
        "Raw readings of two strokes on the turntable",
        "After figure 3 of [Pen]: every channel of accelerometer and gyroscope, seed 0, as the "
        "estimators are given it.",
        panels,
        columns=len(SHOWN),
    )


def told_tolerances(results: Results) -> Figure:
    """Return the noise of the angles over the tolerance's time, with corners and off them."""
    panels = []
    for case in SHOWN:
        told = {case: paper_turntable().tolerance_reached_after_s}
        told |= {
            name: row.reached_after_s
            for name, row in SWEEP.items()
            if row.stroke == case and row.reached_after_s is not None
        }
        lines = []
        for quantity, where in (("jitter", "corners included"), ("jitter_straight", "off corners")):
            jitter = {
                sensors: results.select(
                    suite=NAME,
                    case=list(told),
                    sensors=sensors,
                    estimator="ekf",
                    quantity=quantity,
                )
                .groupby("case")["rmse"]
                .mean()
                for sensors in ("gyro", "accel")
            }
            both = sorted(
                (told[name], name) for name in told if all(name in j for j in jitter.values())
            )
            if both:
                x = np.array([after_s for after_s, _ in both])
                y = np.array([jitter["gyro"][name] / jitter["accel"][name] for _, name in both])
                lines.append(Line(where, x, y.astype(float)))
        panels.append(
            Panel(
                case.partition(": ")[2],
                "tolerance reached after (s, as told)",
                "noise, gyro / accel",
                lines,
                x_log=True,
                y_log=True,
            )
        )
    return Figure(
        "pen-tolerance",
        "How noisy the angles of the gyroscope are, with corners and off them",
        "RMS change of the angles' error from sample to sample, gyroscope alone over accelerometer "
        "alone, EKF, mean over the seeds: below 1 the gyroscope's are less noisy. In what time a "
        "rate may wander by its tolerance is ours, not [Pen]'s: the longer, the more of a changed "
        "reading at a corner the filter takes for a change of the angles.",
        panels,
        columns=len(SHOWN),
    )
