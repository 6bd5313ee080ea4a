"""The error terms over speed, and the EKF's errors by model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel, Style
from benchmark.tasks.results import Results
from suites.printed_cost.over_seeds import OverSeeds, over_seeds
from suites.printed_cost.run import (
    ACCEL_ERROR,
    ACCEL_NOISE,
    AS_PRINTED,
    CONFIGURATIONS,
    MOTION,
    RIGID_BODY,
    SPEEDS,
    TIP_SPEED,
)

LABELS: Mapping[str, str] = MappingProxyType(
    {
        RIGID_BODY: RIGID_BODY,
        "E2 only": "E2: inverse matrix in (5)",
        "E3 only": "E3: sign of x in (6)",
        "E4 only": "E4: no Coriolis term in (6)",
        AS_PRINTED: "as printed: all three",
    }
)
"""Model → its line."""
ON_ANOTHER = "E4 only"
"""Its line is dashed: it lies on the rigid body's."""
ASIDE = (0.94, 0.97, 1.0, 1.03, 1.06)
"""Factors to the speeds of the models, so that bars do not hide each other."""
NOISE = "noise of the sensor, one axis"
SPEED_LABEL = "RMS tip speed (mm/s)"
CAMERA, NO_CAMERA = CONFIGURATIONS
PANELS = (
    (CAMERA, "tip", "mm"),
    (CAMERA, "azimuth", "deg"),
    (CAMERA, "elevation", "deg"),
    (NO_CAMERA, "elevation", "deg"),
)


def figures(results: Results) -> Sequence[Figure]:
    """Return the figure, of the models and speeds that there are."""
    cells = over_seeds(results)
    panels = [_terms(cells), *(_errors(cells, *panel) for panel in PANELS)]
    there = [panel for panel in panels if panel.lines]
    if not there:
        return []
    return [
        Figure(
            "printed-cost",
            "What the printed equations cost, over speed",
            f"Accelerometer and gyroscope; ‘{MOTION}’ played {SPEEDS[0]:g} to {SPEEDS[-1]:g} times "
            "as fast. Bars are the standard deviation over seeds; models stand a little aside of "
            "their speed, so that bars do not hide each other.",
            there,
            columns=2,
        )
    ]


def _terms(cells: Sequence[OverSeeds]) -> Panel:
    """Return what the models' accelerometers say too much, beside the noise of one."""
    lines, noisy = [], [cell for cell in cells if cell.sensors == CAMERA]
    for model, label in LABELS.items():
        there = [cell for cell in noisy if cell.model == model]
        if there and model != RIGID_BODY:
            x, y = (
                np.array([cell.rms[name] for cell in there]) for name in (TIP_SPEED, ACCEL_ERROR)
            )
            lines.append(Line(label, x, y))
    if lines:
        ends = [cell.rms[TIP_SPEED] for cell in noisy]
        x = np.array([min(ends), max(ends)])
        lines.append(Line(NOISE, x, np.full(2, noisy[0].rms[ACCEL_NOISE]), style="dashed"))
    return Panel(
        "printed accelerometer minus rigid body's",
        SPEED_LABEL,
        "RMS error (m/s²)",
        lines,
        x_log=True,
        y_log=True,
    )


def _errors(cells: Sequence[OverSeeds], sensors: str, quantity: str, unit: str) -> Panel:
    lines = []
    for (model, label), aside in zip(LABELS.items(), ASIDE, strict=True):
        there = [cell for cell in cells if (cell.sensors, cell.model) == (sensors, model)]
        if there:
            y, spread = (
                np.array([values[quantity] for values in each])
                for each in ([cell.mean for cell in there], [cell.spread for cell in there])
            )
            x = aside * np.array([cell.rms[TIP_SPEED] for cell in there])
            style: Style = "dashed" if model == ON_ANOTHER else "line"
            lines.append(Line(label, x, y, low=y - spread, high=y + spread, style=style))
    return Panel(
        f"{quantity}, EKF {sensors}", SPEED_LABEL, f"RMS error ({unit})", lines, x_log=True
    )
