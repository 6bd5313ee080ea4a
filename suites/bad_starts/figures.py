"""The errors over time, and the tables of all cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from benchmark.figures.figure import Figure, Line, Panel
from benchmark.tasks.results import Results
from pen_mhe.estimators import ESTIMATORS
from suites.bad_starts.cases import CASES, KNOWLEDGE
from suites.bad_starts.quantities import RATES, UP
from suites.over_runs import over_runs

SHOWN = ("writing-30", "writing-170", "calibrated-170", "strokes-30")
"""A row of the figure each, where they were run."""
ROWS = 4
"""So many cases are shown of a run that has none of these."""
PANELS: Mapping[str, str] = MappingProxyType({UP: "error of up (deg)", RATES: "error (rad/s)"})
"""Quantity → label of its axis."""


def figures(results: Results) -> Sequence[Figure]:
    """Return the errors over time, a row per case: median and 10 to 90 % of the runs."""
    ran = set(results.series["case"])
    cases = [name for name in SHOWN if name in ran] or [name for name in CASES if name in ran]
    cases = cases[:ROWS]
    panels = [
        Panel(f"{case}: {quantity}", "time (s)", label, _lines(results, case, quantity), y_log=True)
        for case in cases
        for quantity, label in PANELS.items()
    ]
    if not panels:
        return []
    told = " ".join(f"{name}: {described(name)}." for name in cases)
    caption = f"Median, and the band of 10 to 90 % of the runs. {told}"
    title = "A wrong attitude at the start: who forgets it, and how soon"
    return [Figure("bad-starts-over-time", title, caption, panels, columns=len(PANELS))]


def described(name: str) -> str:
    """Return a case in words: sensors and motion, what is told, how wrong the start is."""
    case = CASES[name]
    return f"{case.label}; told: {KNOWLEDGE[case.knowledge].label}; start wrong by {case.start} deg"


def _lines(results: Results, case: str, quantity: str) -> list[Line]:
    found = [
        over_runs(results, name, "median", case=case, estimator=name, quantity=quantity)
        for name in ESTIMATORS
    ]
    return [line for line in found if line is not None]
