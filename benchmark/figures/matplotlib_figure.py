"""A figure drawn on paper: matplotlib, for README and notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from benchmark.figures.band import band, interval_lengths
from benchmark.figures.figure import Figure, Line, Panel
from benchmark.figures.layout import places
from benchmark.figures.style import (
    FILLED,
    LINE_WIDTH,
    MARKS,
    PAGE,
    Colour,
    Theme,
    colours_of,
    stroke_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure as Drawing

    from models.arrays import Array

ALONE, STACKED, SQUARE = 3.2, 2.0, 3.6
"""Height in inches of a panel in a single row, of one of several rows, of a path on paper."""

WIDTH = 8.0
LEGEND_CHARACTERS, HANDLE_CHARACTERS = 110, 7
"""What fits beside each other, and what a name's line takes of it."""
MARKED = 40
"""Points of a line that has a mark at each; a longer one has a few."""
JAGGED = 6.0
"""Ranges that a line without dashes goes up and down in all."""


def matplotlib_figure(
    figure: Figure, colours: Mapping[str, Colour] | None = None, theme: Theme = "light"
) -> Drawing:
    """Return the drawing; ``.savefig(path)`` writes it.

    Parameters
    ----------
    colours : line name → colour, from `colours_of` of all figures that stand together
    """
    from matplotlib.figure import Figure as Drawing  # slow to import

    colours = colours_of([figure]) if colours is None else colours
    where = places(figure)
    rows, columns = 1 + max(place.row for place in where), max(figure.columns, 1)
    square = any(panel.equal for panel in figure.panels)
    height = SQUARE if square else ALONE if rows == 1 else STACKED
    drawing = Drawing(figsize=(WIDTH, rows * height + 0.6), layout="constrained")
    drawing.set_facecolor(PAGE["paper"].on(theme))
    drawing.suptitle(_text(figure.title), color=PAGE["ink"].on(theme), fontsize=11)
    drawn: list[Axes] = []
    for number, (panel, place) in enumerate(zip(figure.panels, where, strict=True)):
        shared = drawn[place.shares] if place.shares != number else None
        axes = drawing.add_subplot(rows, columns, number + 1, sharex=shared)
        for line in panel.lines:
            _draw(axes, line, panel, colours[line.name], theme)
        _dress(axes, panel, place.shows_x, theme)
        drawn.append(axes)
    _scaled_alike(figure.panels, drawn)
    handles = {
        label: handle
        for axes in drawn
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    if handles:
        drawing.legend(
            list(handles.values()),
            list(handles),
            loc="outside lower center",
            ncols=min(len(handles), _legend_columns(handles)),
            frameon=False,
            fontsize=9,
            labelcolor=PAGE["ink"].on(theme),
        )
    return drawing


def _legend_columns(names: Iterable[str]) -> int:
    """Return how many columns of names fit beside each other, five at most."""
    return max(1, min(5, LEGEND_CHARACTERS // (max(map(len, names)) + HANDLE_CHARACTERS)))


def _draw(axes: Axes, line: Line, panel: Panel, colour: Colour, theme: Theme) -> None:
    tint, name = colour.on(theme), _text(line.name)
    around, lengths = band(line, panel.y_log), interval_lengths(line)
    if around is not None:
        for part in around.stretches():
            axes.fill_between(
                part.x, part.low, part.high, color=tint, alpha=0.18, linewidth=0, label="_band"
            )
    x = np.asarray(line.x, dtype=float)
    y = np.where(np.isfinite(line.y), line.y, np.nan)
    points, stroke = line.style == "points" or len(x) == 1, stroke_of(colour, line.style)
    dash = () if line.style == "line" and _is_jagged(y) else stroke.dash
    axes.errorbar(
        x,
        y,
        yerr=None if lengths is None else np.stack(lengths),
        label=name,
        color=tint,
        linestyle="none" if points else (0, dash) if dash else "-",
        linewidth=LINE_WIDTH[line.style] * 0.75,
        elinewidth=0.9,
        capsize=2,
        marker=MARKS[stroke.mark][1] if stroke.mark else "o" if points else "none",
        markerfacecolor=tint if stroke.mark in ("", *FILLED) else "none",
        markersize=3.4 if stroke.mark in FILLED else 5.5,
        markeredgewidth=1.0,
        markevery=1 if len(x) <= MARKED else (len(axes.lines) * 7 % 29, max(len(x) // 6, 1)),
    )


def _is_jagged(y: Array) -> bool:
    """Whether a line goes up and down so often that its dashes are not to be seen."""
    seen = y[np.isfinite(y)]
    return len(seen) > 1 and bool(np.abs(np.diff(seen)).sum() > JAGGED * np.ptp(seen))


def _scaled_alike(panels: Sequence[Panel], drawn: Sequence[Axes]) -> None:
    """Give a panel whose lines all have one value the y axis of one with the same label."""
    told: dict[str, tuple[float, float]] = {}
    flat = []
    for panel, axes in zip(panels, drawn, strict=True):
        values = np.concatenate([np.empty(0), *(np.asarray(line.y) for line in panel.lines)])
        seen = values[np.isfinite(values)]
        if len(seen) and np.ptp(seen) == 0 and not panel.y_log:
            flat.append((panel, axes))
        else:
            told.setdefault(panel.y_label, axes.get_ylim())
    for panel, axes in flat:
        axes.set_ylim(told.get(panel.y_label))


def _dress(axes: Axes, panel: Panel, shows_x: bool, theme: Theme) -> None:
    ink, muted, rule = (PAGE[name].on(theme) for name in ("ink", "muted", "rule"))
    axes.set_facecolor(PAGE["paper"].on(theme))
    axes.set_title(_text(panel.title), loc="left", fontsize=9, color=muted)
    axes.set_ylabel(_text(panel.y_label), color=ink, fontsize=9)
    axes.tick_params(which="both", colors=muted, labelsize=8, labelbottom=shows_x)
    if shows_x:
        axes.set_xlabel(_text(panel.x_label), color=ink, fontsize=9)
    if panel.x_log:
        axes.set_xscale("log")
    if panel.y_log:
        axes.set_yscale("log")
    for axis, is_log in ((axes.xaxis, panel.x_log), (axes.yaxis, panel.y_log)):
        if is_log:
            _number_decades(axis)
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim")
    axes.grid(color=PAGE["grid"].on(theme), linewidth=0.7)
    axes.set_axisbelow(True)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(rule)


def _number_decades(axis: Axis) -> None:
    """Write plain numbers on a logarithmic axis: at decades, at 1, 2 and 5, or wherever fit."""
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

    low, high = sorted(axis.get_view_interval())
    for parts in ((1.0,), (1.0, 2.0, 5.0)):
        locator = LogLocator(subs=parts)
        if sum(low <= value <= high for value in locator.tick_values(low, high)) > 2:
            axis.set_major_locator(locator)
            break
    else:
        axis.set_major_locator(MaxNLocator(4))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _text(text: str) -> str:
    # A pair of dollar signs would be taken for a formula.
    return text.replace("$", r"\$")
