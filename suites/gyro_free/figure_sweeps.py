"""Errors over distance and noise, and where the compensation helps."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel, Style
from benchmark.tasks.results import Results
from benchmark.tasks.task import OK
from suites.gyro_free.cases import (
    CASES,
    CLASSICAL,
    COMPENSATED,
    INTEGRATED,
    TWO_ACCELS,
    GyroFreeCase,
)
from suites.gyro_free.simulated import SHOWN

BY_METHOD = (INTEGRATED, COMPENSATED, "ekf", "mhe")
SWEPT: Mapping[str, str] = MappingProxyType(
    {"rate": "rate error (deg/s)", "attitude": "attitude error (deg)", "path": "path error (mm)"}
)
"""Quantity of a sweep → label of its axis."""

SENSORS_SHOWN: Mapping[str, str] = MappingProxyType(
    {estimator: sensors for sensors, names in SHOWN.items() for estimator in names}
)
"""Estimator → the sensors with which figures show it: who has a model is told of no roll."""

BY_DISTANCE: Mapping[str, float] = MappingProxyType(
    {
        name: 1e3 * case.half_distance_m
        for name, case in CASES.items()
        if GyroFreeCase(half_distance_m=case.half_distance_m)
        == GyroFreeCase(
            case.half_distance_m, case.noise_factor, case.gesture, case.errors, case.first_s
        )
    }
)
"""Cases that differ in nothing but l → l in mm."""

BY_NOISE: Mapping[str, float] = MappingProxyType(
    {
        name: case.noise_factor
        for name, case in CASES.items()
        if GyroFreeCase(noise_factor=case.noise_factor)
        == GyroFreeCase(
            case.half_distance_m, case.noise_factor, case.gesture, case.errors, case.first_s
        )
        and case.noise_factor > 0  # a logarithmic axis has no zero
    }
)
"""Cases that differ in nothing but the noise → its factor."""


def sweeps(results: Results) -> tuple[Figure, Figure]:
    """Return errors over the distance, and over the noise."""
    return (
        _sweep(
            results,
            "distance",
            BY_DISTANCE,
            "half distance l (mm)",
            "Errors over the distance of the accelerometers",
            "The same gestures and sensors, mounted at -l and +l from the centre of mass. EKF and "
            "MHE are told that the pen does not roll, as the integration takes it.",
        ),
        _sweep(
            results,
            "noise",
            BY_NOISE,
            "noise, in that of the test case",
            "Errors over the noise of the accelerometers",
            "The bias stays as it is: where the noise is small, bias is all there is. EKF and MHE "
            "as above.",
        ),
    )


def _sweep(
    results: Results, key: str, cases: Mapping[str, float], label: str, title: str, caption: str
) -> Figure:
    panels = [
        Panel(
            name.capitalize(),
            label,
            axis,
            [
                line
                for estimator in BY_METHOD
                if (line := _over(results, estimator, name, cases)) is not None
            ],
            x_log=True,
            y_log=True,
        )
        for name, axis in SWEPT.items()
    ]
    return Figure(
        f"gyro-free-{key}",
        title,
        f"{caption} RMSE, mean over the seeds, bars from the least to the greatest.",
        panels,
        columns=len(panels),
    )


def _over(
    results: Results, estimator: str, quantity: str, cases: Mapping[str, float]
) -> Line | None:
    """Return an RMSE over what the cases differ in."""
    x, values = [], []
    for case, at in sorted(cases.items(), key=lambda item: item[1]):
        rows = results.select(
            case=case,
            sensors=SENSORS_SHOWN.get(estimator, TWO_ACCELS),
            estimator=estimator,
            quantity=quantity,
            status=OK,
        )
        if len(rows):
            x.append(at)
            values.append(rows["rmse"].to_numpy(dtype=float))
    if not x:
        return None
    mean, low, high = (np.array([f(v) for v in values]) for f in (np.mean, np.min, np.max))
    return Line(estimator, np.array(x), mean, low=low, high=high)


def where_it_helps(results: Results) -> Figure:
    """Return the ratio of errors with and without compensation over the noise."""
    before = _over(results, INTEGRATED, "rate", BY_NOISE)
    lines = []
    if before is not None:
        reference = dict(zip(before.x, before.y, strict=True))
        for estimator in CLASSICAL:
            line = _over(results, estimator, "rate", BY_NOISE)
            if line is None:
                continue
            at = [x for x in line.x if x in reference]
            ratio = [
                y / reference[x] for x, y in zip(line.x, line.y, strict=True) if x in reference
            ]
            style: Style = "dashed" if estimator == INTEGRATED else "line"
            lines.append(Line(estimator, np.array(at), np.array(ratio), style=style))
    return Figure(
        "gyro-free-helps",
        "Where the compensation helps, and where it does harm",
        "Rate error with compensation over that without: it helps below 1. Variants differ in the "
        "differentiator (backward, central, 31-points, centred; central and centred look 1 and 7 "
        "samples ahead, no estimator could), in the thresholds of determinant and condition "
        "(bold, strict), and in the part of the correction that is taken (gentle).",
        [
            Panel(
                "Compensated over integrated",
                "noise, in that of the test case",
                "ratio of rate errors",
                lines,
                x_log=True,
                y_log=True,
            )
        ],
    )
