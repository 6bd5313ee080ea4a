"""A figure for a browser: what ``chart.js`` draws, as JSON can hold it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmark.figures.band import band, interval_lengths
from benchmark.figures.decimate import decimate
from benchmark.figures.figure import Figure, Line, Panel
from benchmark.figures.layout import places
from benchmark.figures.style import Colour, colours_of
from models.arrays import Array

DIGITS = 6
"""Significant digits of a number that stands alone."""

STEPS = 5000
"""A long curve is told in steps of which its range has at least so many: a screen has fewer."""

PLAIN = 40
"""Points of a curve that is told number by number."""


def chart(figure: Figure, colours: Mapping[str, Colour] | None = None) -> dict[str, Any]:
    """Return panels with their axes and lines; `packed` says how numbers are told.

    Parameters
    ----------
    colours : line name → colour, from `colours_of` of all figures of a page; a line names its
        colour by its place in it
    """
    names = list(colours_of([figure]) if colours is None else colours)
    wide, narrow = places(figure), places(figure, 1)
    panels = [
        {
            "title": panel.title,
            "x": panel.x_label,
            "y": panel.y_label,
            "logs": [panel.x_log, panel.y_log],
            "equal": panel.equal,
            "shares": place.shares,
            "labelled": [place.shows_x, below.shows_x],
            "lines": [_line(line, panel, names.index(line.name)) for line in panel.lines],
        }
        for panel, place, below in zip(figure.panels, wide, narrow, strict=True)
    ]
    return {"columns": max(figure.columns, 1), "panels": panels}


def _line(line: Line, panel: Panel, number: int) -> dict[str, Any]:
    x, y = np.asarray(line.x, dtype=float), np.asarray(line.y, dtype=float)
    around, lengths = band(line, panel.y_log), interval_lengths(line)
    ends = () if around is None else (around.low, around.high)
    sides = () if np.all(np.diff(x) >= 0) else (x,)  # a path: its turns in x count as well
    kept = decimate(y, *sides, *(np.where(np.isfinite(end), end, y) for end in ends))
    told: dict[str, Any] = {"x": packed(x[kept], panel.x_log), "y": packed(y[kept], panel.y_log)}
    if around is not None:
        told["band"] = [packed(end[kept], panel.y_log) for end in ends]
    if lengths is not None:
        told["bars"] = [
            packed((y + sign * length)[kept], panel.y_log)
            for sign, length in zip((-1, 1), lengths, strict=True)
        ]
    return {"name": number, "style": line.style, **told}


def packed(values: Array, log: bool = False) -> list[float | None] | dict[str, Any]:
    """Return numbers as they are, or of a long curve ``o`` and ``s`` of o + s · sum of ``d``.

    On a logarithmic axis they are the logarithms. JSON knows neither NaN nor infinity: null is
    a gap.
    """
    told = np.where(values > 0, values, np.nan) if log else values
    if len(told) <= PLAIN or not np.isfinite(told).any():
        return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in told.tolist()]
    told = np.log10(told) if log else told
    seen = told[np.isfinite(told)]
    spread = float(np.ptp(seen))
    step = 10.0 ** math.floor(math.log10(spread / STEPS)) if spread > 0 else 1.0
    steps = iter(np.diff(np.round((seen - seen[0]) / step), prepend=0).astype(int).tolist())
    deltas = [next(steps) if is_seen else None for is_seen in np.isfinite(told).tolist()]
    return {"o": float(seen[0]), "s": step, "d": deltas} | ({"log": 1} if log else {})
