"""Every time of the suite speed, and what was found in it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from benchmark.figures.figure import Table
from benchmark.report.numbers import in_unit
from benchmark.tasks.results import Results
from suites.speed import outcomes as of
from suites.speed.cases import CASES
from suites.speed.read import Found, found_in

HEAD = (
    *("case", "contender", "mode", "least CPU", "median CPU", "least", "median", "99 %", "longest"),
    *("cost", "newest state, σ", "at worst, σ", "excess, σ", "solved", "build"),
    *("active rows", "core", "version, clock"),
)
TIMES = (of.LEAST_CPU, of.MEDIAN_CPU, of.LEAST, of.MEDIAN, of.P99, of.LONGEST)
DEVIATIONS = (of.NEWEST, of.NEWEST_WORST, of.EXCESS)


def tables(results: Results) -> Sequence[Table]:
    """Return a table of the windows, and one of the streams."""
    found = found_in(results)
    kinds = (
        ("Time per window", "CPU time beside wall time; σ: standard deviations.", False),
        ("Time per sample along a stream", "“Batch”: the whole stream in one call.", True),
    )
    return [
        (title, caption, HEAD, rows)
        for title, caption, is_stream in kinds
        if (rows := [row for each in found for row in _rows(each, is_stream)])
    ]


def _rows(found: Found, is_stream: bool) -> list[tuple[str, ...]]:
    if CASES[found.case].is_stream != is_stream:
        return []
    return [
        (
            found.case,
            found.contender,
            mode,
            *(in_unit(1e-6 * found.figure(mode, name)) for name in TIMES),
            _text(found.figure(mode, of.COST), "{:.10g}"),
            *(_text(found.figure(mode, name), "{:.1e}") for name in DEVIATIONS),
            _text(found.figure(mode, of.SOLVED), "{:.0%}"),
            in_unit(found.figure(mode, of.BUILD)),
            _text(found.figures.get(of.ACTIVE, math.nan), "{:.1f}"),
            _text(found.figures.get(of.CORES, math.nan), "{:.0%}"),
            found.says,
        )
        for mode in found.modes
    ]


def _text(figure: float, form: str) -> str:
    return "" if math.isnan(figure) else form.format(figure)
