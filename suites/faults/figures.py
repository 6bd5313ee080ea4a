"""How long wrong answers stay silent, how soon estimates are right again, and some of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel, Style
from benchmark.tasks.results import Results
from suites.faults.contenders import CONTENDERS
from suites.faults.protocol import SENSORS
from suites.faults.quantities import RIGHT, SILENT
from suites.faults.run import ERROR, SHOWN, SHOWN_ESTIMATORS, SHOWN_SENSORS
from suites.faults.scoring import SILENT_S

TIMES_S = np.geomspace(0.01, 10, 91)


def figures(results: Results) -> Sequence[Figure]:
    """Return every figure for which there are rows or series."""
    drawn = (_silent(results), _right(results), _shown(results))
    return [figure for figure in drawn if figure.panels]


def _silent(results: Results) -> Figure:
    return Figure(
        "faults-silent",
        "Wrong without a word: in how many cells, and for how long",
        "A cell is a fault with a choice of sensors, and its worst seed. "
        f"{SILENT_S:g} s may be silent.",
        [
            Panel(
                sensors, "silent and wrong for longer than (s)", "share of cells (%)", lines, True
            )
            for sensors in SENSORS
            if (lines := _shares(results, sensors, SILENT, is_later=True))
        ],
        columns=2,
    )


def _right(results: Results) -> Figure:
    return Figure(
        "faults-right",
        "Right again: in how many cells, and how soon",
        "From the end of a fault (its begin, where it stays) until estimates are within their "
        "claims again; a cell is its worst seed.",
        [
            Panel(sensors, "within (s)", "share of cells (%)", lines, True)
            for sensors in SENSORS
            if (lines := _shares(results, sensors, RIGHT, is_later=False))
        ],
        columns=2,
    )


def _shares(results: Results, sensors: str, quantity: str, is_later: bool) -> list[Line]:
    """Return how many % of the cells have a time beyond each of `TIMES_S`, or up to it."""
    found = []
    for name, contender in reversed(list(CONTENDERS.items())):
        rows = results.select(sensors=sensors, estimator=name, quantity=quantity)
        if len(rows):
            worst = rows.groupby("case")["bias"].max().to_numpy(dtype=float)
            beyond = (worst > TIMES_S[:, None]).mean(axis=1)
            shares = 100 * (beyond if is_later else 1 - beyond)
            style: Style = "line" if contender.is_watched else "dashed"
            found.append(Line(name, TIMES_S, shares, style=style))
    return found


def _shown(results: Results) -> Figure:
    panels = []
    for case in SHOWN:
        lines = [
            results.lines(name, case=case, sensors=SHOWN_SENSORS, estimator=name, quantity=ERROR)
            for name in SHOWN_ESTIMATORS
        ]
        there = [line for line in lines if line is not None]
        if there:
            panels.append(Panel(case, "time (s)", f"{ERROR} (deg)", there))
    return Figure(
        "faults-shown",
        "Four faults over time",
        f"Seed 0, {SHOWN_SENSORS}, the EKF with and without a watch. Bands are two claimed "
        "standard deviations.",
        panels,
        columns=2,
    )
