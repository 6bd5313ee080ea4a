"""The judged state of every problem over time, on every estimator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.figures.band import SIGMAS
from benchmark.figures.figure import TRUTH, Figure, Line, Panel
from benchmark.from_mhe import REFERENCE
from benchmark.tasks.results import Results
from suites.classics import do_mpc
from suites.classics.problems import PROBLEMS

UNSCENTED = "ukf"
SHOWN = (*BENCHMARK_ESTIMATORS, UNSCENTED, REFERENCE, do_mpc.NAME)


def figures(results: Results) -> Sequence[Figure]:
    """Return every figure for which there are series."""
    panels = [
        Panel(problem.title, "time (s)", problem.label, _readable(lines), own_x=True)
        for case, problem in PROBLEMS.items()
        if (lines := _lines(results, case))
    ]
    if not panels:
        return []
    return [
        Figure(
            "classics-states",
            "The state that each problem is about",
            "Seed 0. Bands are two claimed standard deviations, where they are narrower than all "
            "curves are apart. do-mpc claims none; in a short run it is not asked for every "
            "problem.",
            panels,
            columns=2,
        )
    ]


def _lines(results: Results, case: str) -> list[Line]:
    found = [results.lines(name, case=case, estimator=name) for name in SHOWN]
    lines = [line for line in found if line is not None]
    truths = (results.lines(TRUTH, truth=True, case=case, estimator=name) for name in SHOWN)
    truth = next((line for line in truths if line is not None), None)
    return [truth, *lines] if truth is not None else lines


def _readable(lines: Sequence[Line]) -> list[Line]:
    """Return the lines without what would be the whole panel: bands of a prior that says little."""
    values = np.concatenate([line.y[np.isfinite(line.y)] for line in lines])
    widest = float(np.ptp(values)) / (2 * SIGMAS) if values.size else 0.0
    return [
        line
        if line.std is None
        else replace(line, std=np.where(line.std <= widest, line.std, np.nan))
        for line in lines
    ]
