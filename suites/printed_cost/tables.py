"""The EKF's errors by speed, sensors and model: mean over the seeds, and spread."""

from __future__ import annotations

import math
from collections.abc import Sequence

from benchmark.figures.figure import Table
from benchmark.tasks.results import Results
from pen_mhe.errors import NOT_OBSERVABLE
from suites.printed_cost.over_seeds import OverSeeds, over_seeds
from suites.printed_cost.run import ACCEL_ERROR, DURATION_S, ESTIMATED, MOTION, TIP_SPEED

HEAD = (
    *("case", "tip speed, mm/s", "sensors", "model", "accelerometer error, m/s²"),
    *("tip, mm", "elevation, deg", "azimuth, deg"),
)


def tables(results: Results) -> Sequence[Table]:
    """Return one table, of the models and speeds that there are."""
    cells = over_seeds(results)
    if not cells:
        return []
    caption = (
        f"Mean ± standard deviation over {max(cell.seeds for cell in cells)} seeds of ‘{MOTION}’, "
        f"{DURATION_S:g} s each."
    )
    return [("RMS errors of the EKF", caption, HEAD, [_row(cell) for cell in cells])]


def _row(cell: OverSeeds) -> tuple[str, ...]:
    return (
        cell.case,
        f"{cell.rms[TIP_SPEED]:.0f}",
        cell.sensors,
        cell.model,
        f"{cell.rms[ACCEL_ERROR]:.2g}",
        *(_with_spread(cell, name) for name in ESTIMATED),
    )


def _with_spread(cell: OverSeeds, name: str) -> str:
    if name not in cell.mean:
        return NOT_OBSERVABLE
    spread = cell.spread[name]
    return f"{cell.mean[name]:.3f}" + ("" if math.isnan(spread) else f" ± {spread:.3f}")
