"""How long wrong answers stay silent, how soon estimates are right again, and some of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel, Style
from benchmark.tasks.results import Results
from suites.faults.contenders import CONTENDERS
from suites.faults.protocol import SENSORS
from suites.faults.quantities import RIGHT, SILENT
from suites.faults.run import ERROR, SHOWN, SHOWN_ESTIMATORS, SHOWN_SENSORS
from suites.faults.scoring import SILENT_S

TIMES_S = np.geomspace(0.01, 10, 361)
HOLE_S = 0.5
"""A longer time between instants is a hole in the curve."""


def figures(results: Results) -> Sequence[Figure]:
    """Return every figure for which there are rows or series."""
    drawn = (_silent(results), _right(results), _shown(results))
    return [figure for figure in drawn if figure.panels]


def _silent(results: Results) -> Figure:
    return _over_times(
        results,
        SILENT,
        "faults-silent",
        "Wrong without a word: in how many cells, and for how long",
        f"A cell is a fault with a choice of sensors, and its worst seed. {SILENT_S:g} s may be "
        "silent.",
        "silent and wrong for longer than (s)",
    )


def _right(results: Results) -> Figure:
    return _over_times(
        results,
        RIGHT,
        "faults-right",
        "Right again: in how many cells not, and how soon",
        "From the end of a fault (its begin, where it stays) until estimates are within their "
        "claims again; a cell is its worst seed.",
        "not right again within (s)",
    )


def _over_times(
    results: Results, quantity: str, key: str, title: str, caption: str, x_label: str
) -> Figure:
    """Return a panel for each choice of sensors: in how many cells a time is longer."""
    panels = [
        Panel(sensors, x_label, "share of cells (%)", lines, x_log=True)
        for sensors in SENSORS
        if (lines := _shares(results, sensors, quantity))
    ]
    return Figure(key, title, caption, panels, columns=min(2, len(panels)))


def _shares(results: Results, sensors: str, quantity: str) -> list[Line]:
    """Return how many % of the cells have a time beyond each of `TIMES_S`."""
    found = []
    for name, contender in reversed(list(CONTENDERS.items())):
        rows = results.select(sensors=sensors, estimator=name, quantity=quantity)
        if len(rows):
            worst = rows.groupby("case")["bias"].max().to_numpy(dtype=float)
            shares = 100 * (worst > TIMES_S[:, None]).mean(axis=1)
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
        there = [_with_gaps(line) for line in lines if line is not None]
        if there:
            panels.append(Panel(case, "time (s)", f"{ERROR} (deg)", there, own_x=True))
    return Figure(
        "faults-shown",
        "Four faults over time",
        f"Seed 0, {SHOWN_SENSORS}, the EKF with and without a watch. Bands are two claimed "
        "standard deviations.",
        panels,
        columns=min(2, len(panels)),
    )


def _with_gaps(line: Line) -> Line:
    """Return a line that is not drawn across a hole in time; dashed without a watch."""
    assert line.std is not None
    holes = np.flatnonzero(np.diff(line.x) > HOLE_S) + 1
    x, y, std = (np.insert(values, holes, np.nan) for values in (line.x, line.y, line.std))
    style: Style = "line" if CONTENDERS[line.name].is_watched else "dashed"
    return replace(line, x=x, y=y, std=std, style=style)
