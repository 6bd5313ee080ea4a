"""The judged state of every problem over time, on every estimator."""

from __future__ import annotations

from collections.abc import Sequence

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.figures.figure import TRUTH, Figure, Line, Panel
from benchmark.from_mhe import REFERENCE
from benchmark.tasks.results import Results
from suites.classics import do_mpc
from suites.classics.problems import PROBLEMS

SHOWN = (*BENCHMARK_ESTIMATORS, REFERENCE, do_mpc.NAME)


def figures(results: Results) -> Sequence[Figure]:
    """Return every figure for which there are series."""
    panels = [
        Panel(case, "time (s)", problem.label, lines)
        for case, problem in PROBLEMS.items()
        if (lines := _lines(results, case))
    ]
    if not panels:
        return []
    return [
        Figure(
            "classics-states",
            "The state that each problem is about",
            "Seed 0. Bands are two claimed standard deviations.",
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
