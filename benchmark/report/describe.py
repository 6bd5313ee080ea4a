"""A figure in words, for those who do not see it."""

from __future__ import annotations

import numpy as np

from benchmark.figures.figure import Figure, Line
from benchmark.report.numbers import number


def describe(figure: Figure) -> str:
    """Return what a figure's panels show: axes, lines and the range of each."""
    parts = []
    for panel in figure.panels:
        lines = "; ".join(_line(line) for line in panel.lines) or "no lines"
        scale = " (logarithmic)" if panel.y_log else ""
        parts.append(
            f"{panel.title or figure.title}: {panel.y_label}{scale} over {panel.x_label}. {lines}."
        )
    return " ".join(parts)


def _line(line: Line) -> str:
    y = np.asarray(line.y, dtype=float)
    seen = y[np.isfinite(y)]
    if not len(seen):
        return f"{line.name}: no values"
    of_std = "" if line.std is None else ", with a band of two standard deviations"
    around = of_std if line.band is None else ", with a band"
    return f"{line.name}: {number(seen.min())} to {number(seen.max())}{around}"
