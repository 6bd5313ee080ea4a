"""The worst cells as a table: peak error, time until right, silence, what was said."""

from __future__ import annotations

import math
from collections.abc import Sequence

from benchmark.figures.figure import Table
from benchmark.tasks.results import Results
from suites.faults.contenders import CONTENDERS
from suites.faults.protocol import SENSORS, faults_for
from suites.faults.quantities import PEAK, PEAK_TIP, RIGHT, SILENT
from suites.faults.unnoticeable import declared

HEAD = (
    *("Fault", "Sensors", "Silent and wrong, s", "Right again after, s"),
    *("Peak error, deg", "Peak of the tip, mm", "What was said"),
)
NOTHING, UNNOTICEABLE = "nothing", "nobody could notice it in time"


def tables(results: Results) -> Sequence[Table]:
    """Return a table for every contender: its cells, the worst first."""
    caption = (
        "The worst seed of each cell, the longest silence first. Said is what the fault-free run "
        f"never says, and for how long. Of {len(_declared())} cells in {_all_cells()} it was "
        "computed beforehand that in some seed nobody could notice in time; they are marked, and "
        "judged like all others."
    )
    return [
        (f"Every cell of {name}", caption, HEAD, rows)
        for name in CONTENDERS
        if (rows := _rows(results, name))
    ]


def _rows(results: Results, name: str) -> list[tuple[str, ...]]:
    rows = results.select(estimator=name, quantity=[SILENT, RIGHT, PEAK, PEAK_TIP])
    if not len(rows):
        return []
    worst: dict[tuple[str, str], dict[str, float]] = {}
    said: dict[tuple[str, str], str] = {}
    for row in rows.sort_values("bias", kind="stable").to_dict("records"):  # the worst seed last
        cell, quantity = (str(row["case"]), str(row["sensors"])), str(row["quantity"])
        worst.setdefault(cell, {})[quantity] = float(row["bias"])
        if quantity == SILENT:
            said[cell] = str(row["reason"] or NOTHING)
    unnoticeable, found = _declared(), []
    for cell in sorted(said, key=lambda cell: (-worst[cell][SILENT], SENSORS.index(cell[1]), cell)):
        figures = (
            _figure(worst[cell].get(part, math.nan)) for part in (SILENT, RIGHT, PEAK, PEAK_TIP)
        )
        words = f"{said[cell]} ({UNNOTICEABLE})" if cell in unnoticeable else said[cell]
        found.append((*cell, *figures, words))
    return found


def _declared() -> set[tuple[str, str]]:
    """Return fault and sensors of the cells that were declared unnoticeable."""
    return {(each.fault, each.sensors) for each in declared()}


def _all_cells() -> int:
    return sum(len(faults_for(sensors)) for sensors in SENSORS)


def _figure(value: float) -> str:
    return "" if math.isnan(value) else "never" if math.isinf(value) else f"{value:.3g}"
