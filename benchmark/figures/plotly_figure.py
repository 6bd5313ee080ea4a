"""A figure drawn for a browser: the JSON of plotly."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmark.figures.band import Band, band, interval_lengths
from benchmark.figures.decimate import decimate
from benchmark.figures.figure import Figure, Line, Panel
from benchmark.figures.layout import Place, places
from benchmark.figures.style import LINE_WIDTH, PAGE, POINT_SIZE, Colour, Theme, colours_of
from models.arrays import Array

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
DIGITS = 6
"""Significant digits of a coordinate."""

ALONE, STACKED, SQUARE = 320, 190, 340
"""Height in pixels of a panel in a single row, of one of several rows, of a path on paper."""

TITLE, AXIS, EDGE = 30, 52, 12
"""Pixels above a panel for its title, below it for its x axis, and around a figure."""

COLUMN_GAP = 0.13
"""Between columns, as a part of the width of a figure of two columns."""


def plotly_figure(
    figure: Figure, colours: Mapping[str, Colour] | None = None, theme: Theme = "light"
) -> dict[str, Any]:
    """Return ``{"data": …, "layout": …}``, which plotly draws and JSON can hold.

    Parameters
    ----------
    colours : line name → colour, from `colours_of` of all figures of a page
    """
    colours = colours_of([figure]) if colours is None else colours
    traces: list[dict[str, Any]] = []
    named: set[str] = set()
    for number, panel in enumerate(figure.panels):
        axes = {"xaxis": _axis("x", number), "yaxis": _axis("y", number)}
        for line in panel.lines:
            for trace in _traces(line, panel, colours[line.name], theme):
                shown = trace.pop("in_legend") and line.name not in named
                named |= {line.name} if shown else set()
                traces.append(trace | axes | {"showlegend": shown})
    return {"data": traces, "layout": plotly_layout(figure, theme=theme)}


def plotly_text(text: str) -> str:
    """Return a text that plotly shows as it is, instead of taking parts of it for markup."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _traces(line: Line, panel: Panel, colour: Colour, theme: Theme) -> list[dict[str, Any]]:
    x, y = np.asarray(line.x, dtype=float), np.asarray(line.y, dtype=float)
    around = band(line, panel.y_log)
    ends = () if around is None else (around.low, around.high)
    sides = () if np.all(np.diff(x) >= 0) else (x,)  # a path: its turns in x count as well
    kept = decimate(y, *sides, *(np.where(np.isfinite(end), end, y) for end in ends))
    trace: dict[str, Any] = {
        "type": "scatter",
        "name": plotly_text(line.name),
        "legendgroup": plotly_text(line.name),
        "in_legend": True,
        "x": _numbers(x[kept]),
        "y": _numbers(y[kept]),
        "mode": "markers" if line.style == "points" else "lines",
        "line": {"color": colour.on(theme), "width": LINE_WIDTH[line.style]},
        "marker": {"color": colour.on(theme), "size": POINT_SIZE},
        "connectgaps": False,
    }
    if line.style == "dashed":
        trace["line"]["dash"] = "dash"
    lengths = interval_lengths(line)
    if lengths is not None:
        trace["error_y"] = {
            "type": "data",
            "symmetric": False,
            "arrayminus": _numbers(lengths[0][kept]),
            "array": _numbers(lengths[1][kept]),
            "color": colour.on(theme),
            "thickness": 1.2,
            "width": 3,
        }
    if len(kept) == 1 and trace["mode"] == "lines":
        trace["mode"] = "lines+markers"  # a line of one point would not be seen
    if around is None:
        return [trace]
    return [_filled(around.take(kept), trace["name"], colour, theme), trace]


def _filled(around: Band, name: str, colour: Colour, theme: Theme) -> dict[str, Any]:
    # One closed outline per stretch without a gap.
    x: list[float | None] = []
    y: list[float | None] = []
    for part in around.stretches():
        x += [*_numbers(part.x), *_numbers(part.x[::-1]), None]
        y += [*_numbers(part.high), *_numbers(part.low[::-1]), None]
    return {
        "type": "scatter",
        "name": name,
        "legendgroup": name,
        "in_legend": False,
        "x": x,
        "y": y,
        "mode": "lines",
        "line": {"width": 0, "color": colour.on(theme)},
        "fill": "toself",
        "fillcolor": colour.band(theme),
        "hoverinfo": "skip",
    }


def plotly_layout(
    figure: Figure, columns: int | None = None, theme: Theme = "light"
) -> dict[str, Any]:
    """Return the layout: axes, titles, sizes.

    Parameters
    ----------
    columns : panels beside each other, other than the figure asks for: 1 on a phone
    """
    where = places(figure, columns)
    rows = 1 + max((place.row for place in where), default=0)
    across = 1 + max((place.column for place in where), default=0)
    heights, gaps = _rows(figure, where, rows)
    inner = sum(heights) + sum(gaps)
    ink, muted = PAGE["ink"].on(theme), PAGE["muted"].on(theme)
    layout: dict[str, Any] = {
        "height": inner + TITLE + AXIS + 2 * EDGE,
        "margin": {"l": 62, "r": EDGE, "t": TITLE + EDGE, "b": AXIS + EDGE},
        "font": {"family": FONT, "size": 13, "color": ink},
        "paper_bgcolor": "rgba(0, 0, 0, 0)",
        "plot_bgcolor": "rgba(0, 0, 0, 0)",
        "hovermode": "closest",
        "hoverlabel": {
            "bgcolor": PAGE["raised"].on(theme),
            "bordercolor": PAGE["rule"].on(theme),
            "font": {"color": ink, "size": 13},
            "namelength": -1,
        },
        "legend": {"orientation": "h", "x": 0, "y": 1 + (TITLE + 4) / inner, "yanchor": "bottom"},
        "modebar": {
            "color": muted,
            "activecolor": ink,
            "bgcolor": "rgba(0, 0, 0, 0)",
        },
        "annotations": [],
        "uirevision": "kept",
    }
    for number, (panel, place) in enumerate(zip(figure.panels, where, strict=True)):
        x, y = _axis("x", number), _axis("y", number)
        top = 1 - (sum(heights[: place.row]) + sum(gaps[: place.row])) / inner
        layout[x.replace("x", "xaxis")] = _x_axis(panel, place, theme) | {
            "anchor": y,
            "domain": _across(place.column, across),
        }
        layout[y.replace("y", "yaxis")] = _y_axis(panel, x, theme) | {
            "anchor": x,
            "domain": [max(top - heights[place.row] / inner, 0.0), top],
        }
        if place.shares != number:
            layout[x.replace("x", "xaxis")]["matches"] = _axis("x", place.shares)
        layout["annotations"].append(_title(panel, x, y, theme))
    return layout


def _rows(figure: Figure, where: list[Place], rows: int) -> tuple[list[int], list[int]]:
    heights, gaps = [], []
    for row in range(rows):
        mine = [
            (p, place) for p, place in zip(figure.panels, where, strict=True) if place.row == row
        ]
        square = any(panel.equal for panel, _ in mine)
        heights.append(SQUARE if square else ALONE if rows == 1 else STACKED)
        labelled = any(place.shows_x for _, place in mine)
        gaps.append(TITLE + EDGE + (AXIS if labelled else 0))
    return heights, gaps[:-1]


def _across(column: int, columns: int) -> list[float]:
    gap = COLUMN_GAP if columns <= 2 else 2 * COLUMN_GAP / columns
    width = (1 - gap * (columns - 1)) / columns
    left = column * (width + gap)
    return [left, min(left + width, 1.0)]


def _x_axis(panel: Panel, place: Place, theme: Theme) -> dict[str, Any]:
    axis = _plain_axis(panel.x_log, theme)
    axis["showticklabels"] = place.shows_x
    if place.shows_x:
        axis["title"] = {"text": plotly_text(panel.x_label), "standoff": 8}
    if panel.equal:
        axis["constrain"] = "domain"
    return axis


def _y_axis(panel: Panel, x: str, theme: Theme) -> dict[str, Any]:
    axis = _plain_axis(panel.y_log, theme)
    axis["title"] = {"text": plotly_text(panel.y_label), "standoff": 6}
    axis["automargin"] = True
    if panel.equal:
        axis |= {"scaleanchor": x, "scaleratio": 1, "constrain": "domain"}
    return axis


def _plain_axis(log: bool, theme: Theme) -> dict[str, Any]:
    rule = PAGE["rule"].on(theme)
    axis: dict[str, Any] = {
        "gridcolor": PAGE["grid"].on(theme),
        "linecolor": rule,
        "tickcolor": rule,
        "showline": True,
        "ticks": "outside",
        "ticklen": 4,
        "zeroline": not log,
        "zerolinecolor": rule,
        "zerolinewidth": 1,
        "hoverformat": ".4~g",
        "tickfont": {"color": PAGE["muted"].on(theme), "size": 12},
    }
    if log:
        axis |= {"type": "log", "dtick": 1, "exponentformat": "power"}
    return axis


def _title(panel: Panel, x: str, y: str, theme: Theme) -> dict[str, Any]:
    return {
        "text": plotly_text(panel.title),
        "xref": f"{x} domain",
        "yref": f"{y} domain",
        "x": 0,
        "y": 1,
        "xanchor": "left",
        "yanchor": "bottom",
        "yshift": 4,
        "showarrow": False,
        "font": {"size": 13, "color": PAGE["muted"].on(theme)},
    }


def _axis(letter: str, number: int) -> str:
    return letter if number == 0 else f"{letter}{number + 1}"


def _numbers(values: Array) -> list[float | None]:
    # JSON knows neither NaN nor infinity: null is a gap.
    return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in values.tolist()]
