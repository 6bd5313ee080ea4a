"""Figures of the suite speed: how near to the optimum in which time, and time over the horizon."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel
from benchmark.report.numbers import number
from benchmark.tasks.results import Results
from suites.shared_core import LEAST_SHARE
from suites.speed.cases import CASES
from suites.speed.contender import CONVERGED, CONVERGED_CALL, ONE_PASS, PASS_CALL
from suites.speed.outcomes import CORES, MEDIAN, NEWEST
from suites.speed.problems import Problem
from suites.speed.read import Found, found_in

WHOLE = (ONE_PASS, CONVERGED)
SHOWN = (PASS_CALL, CONVERGED_CALL, *WHOLE)
"""Modes of a window: a contender's compiled call, then all of its call."""
HORIZON_PROBLEM = "pen15"
TIME = "median time per window (ms)"


def figures(results: Results) -> Sequence[Figure]:
    """Return every figure for which there are rows."""
    found = [each for each in found_in(results) if not CASES[each.case].is_stream]
    drawn = (_quality(found), _horizons(found))
    return [figure for figure in drawn if any(panel.lines for panel in figure.panels)]


def _title(problem: Problem) -> str:
    return f"{problem.name}, N = {problem.horizon}{', bounded' if problem.bounded else ''}"


def _quality(found: Sequence[Found]) -> Figure:
    """Distance from the optimum over time, a panel per problem."""
    panels = [
        Panel(
            _title(CASES[case].problem),
            TIME,
            "distance (σ)",
            [line for each in found if each.case == case and (line := _contender(each))],
            x_log=True,
            y_log=True,
            own_x=True,
        )
        for case in dict.fromkeys(each.case for each in found)
    ]
    return Figure(
        "speed",
        "How near to the optimum, in which time",
        "Distance of the newest state from the optimum in its standard deviations, median over "
        "the windows. Where a contender has two points the left one is its compiled call, the "
        "right one all that is called from Python. What makes one Gauss-Newton pass has what that "
        "pass leaves; what converges lies below." + _shared(found),
        panels,
        columns=2,
    )


def _shared(found: Sequence[Found]) -> str:
    """Return a sentence about cases whose times are too long; empty where there is none."""
    cases = dict.fromkeys(each.case for each in found if each.figures[CORES] < LEAST_SHARE)
    return f" Other work ran beside {', '.join(cases)}: times are too long." if cases else ""


def _contender(found: Found) -> Line | None:
    """Return a contender's modes from its compiled call to all of it; None without a distance."""
    modes = [mode for mode in SHOWN if mode in found.modes]
    time = 1e-3 * np.array([found.figure(mode, MEDIAN) for mode in modes])
    away = np.array([found.figure(mode, NEWEST) for mode in modes])
    away[away <= 0] = np.nan  # a logarithmic axis has no zero
    return Line(found.contender, time, away) if np.isfinite(away).any() else None


def _horizons(found: Sequence[Found]) -> Figure:
    """Time of whole calls over the horizon, with slopes."""
    panels, slopes = [], []
    for bounded in (False, True):
        of_it = [
            each
            for each in found
            if (problem := CASES[each.case].problem).name == HORIZON_PROBLEM
            and problem.bounded == bounded
        ]
        lines = [_over_horizon(name, of_it) for name in dict.fromkeys(e.contender for e in of_it)]
        title = HORIZON_PROBLEM + (", bounded" if bounded else "")
        if lines:
            panels.append(Panel(title, "horizon N", TIME, lines, x_log=True, y_log=True))
        said = [f"{line.name} {number(_slope(line))}" for line in lines if len(line.x) > 1]
        slopes += [f"{title}: {', '.join(said)}."] if said else []
    return Figure(
        "speed-horizon",
        "Time over the horizon",
        "All that is called from Python."
        + (f" Slopes (1 is linear): {' '.join(slopes)}" if slopes else "")
        + _shared([each for each in found if each.case.startswith(HORIZON_PROBLEM)]),
        panels,
        columns=2,
    )


def _over_horizon(name: str, found: Sequence[Found]) -> Line:
    points = sorted(
        (CASES[each.case].problem.horizon, 1e-3 * each.figure(mode, MEDIAN))
        for each in found
        if each.contender == name
        for mode in each.modes
        if mode in WHOLE
    )
    horizons, times = np.array(points, dtype=float).reshape(-1, 2).T
    return Line(name, horizons, times)


def _slope(line: Line) -> float:
    return float(np.polyfit(np.log(line.x), np.log(line.y), 1)[0])
