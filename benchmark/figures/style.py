"""Colours and strokes of every drawing and of the report's page: one table, light and dark."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from types import MappingProxyType
from typing import Literal

from benchmark.figures.figure import TRUTH, Figure, Style

Theme = Literal["light", "dark"]
THEMES: tuple[Theme, ...] = ("light", "dark")


@dataclass(frozen=True)
class Colour:
    """A colour on light and on dark paper, as ``#rrggbb``."""

    light: str
    dark: str

    def on(self, theme: Theme) -> str:
        """Return the colour for a theme."""
        return self.light if theme == "light" else self.dark


NAMED: Mapping[str, Colour] = MappingProxyType(
    {
        TRUTH: Colour("#16191d", "#f4f5f6"),
        "ekf": Colour("#0a5fb4", "#6cb2f5"),
        "mhe-rti": Colour("#007a63", "#45d3b0"),
        "mhe": Colour("#c8420a", "#ff9655"),
        "mhe-sparse": Colour("#a1247d", "#f28bcd"),
        "mhe-ipopt": Colour("#6a4fc4", "#b7a4ff"),
        "fixed-weight": Colour("#8b6900", "#e3c34a"),
        "gyro-free": Colour("#00758c", "#4ecbe4"),
        "do-mpc": Colour("#5d6670", "#aab4bf"),
        "ukf": Colour("#557a00", "#b2d84f"),
    }
)
"""Line name → colour. Neighbours differ in lightness or hue also without red and green."""

OTHERS: tuple[Colour, ...] = (
    Colour("#3b4a9e", "#97a6ff"),
    Colour("#b5305a", "#ff8bab"),
    Colour("#7d7a2f", "#d6d27a"),
    Colour("#7a5641", "#d9ae94"),
    Colour("#0d5c8a", "#7ad0ff"),
    Colour("#914ba8", "#dd9ff2"),
    Colour("#a05a00", "#ffb84d"),
)
"""Colours of names that the table has not."""

PAGE: Mapping[str, Colour] = MappingProxyType(
    {
        "paper": Colour("#ffffff", "#14171b"),
        "raised": Colour("#f6f7f9", "#1c2026"),
        "ink": Colour("#1c2024", "#e6e8ea"),
        "muted": Colour("#59626c", "#a3acb6"),
        "rule": Colour("#d9dde2", "#343a42"),
        "grid": Colour("#e6e9ed", "#2b3037"),
        "link": Colour("#0a58a8", "#7dbbf7"),
        "good": Colour("#1b6b3a", "#6fd394"),
        "bad": Colour("#a8281c", "#ff9b8f"),
        "open": Colour("#7a5700", "#e8c25a"),
        "level-0": Colour("#9cc9f2", "#1f5d99"),
        "level-1": Colour("#bfddf7", "#1e4a78"),
        "level-2": Colour("#d9eafa", "#1d3a5b"),
        "level-3": Colour("#ecf4fc", "#1c2d43"),
        "level-4": Colour("#fafbfc", "#191e25"),
    }
)
"""Colours of paper, text and axes; ``level-0`` to ``level-4`` shade good to bad figures."""

LINE_WIDTH: Mapping[Style, float] = MappingProxyType({"line": 1.6, "dashed": 1.6, "points": 0.0})

MARKS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "dot": ("m-2.8 0a2.8 2.8 0 1 0 5.6 0a2.8 2.8 0 1 0-5.6 0z", "o"),
        "square": ("m-4-4h8v8h-8z", "s"),
        "triangle": ("m0-6.6l6 10.4h-12z", "^"),
        "diamond": ("m0-7.4l7.4 7.4l-7.4 7.4l-7.4-7.4z", "D"),
        "cross": ("m-4-4l8 8m0-8l-8 8", "x"),
        "plus": ("m-5.5 0h11m-5.5-5.5v11", "+"),
        "wedge": ("m0 6.6l6-10.4h-12z", "v"),
        "ring": ("m-5.5 0a5.5 5.5 0 1 0 11 0a5.5 5.5 0 1 0-11 0z", "o"),
        "star": ("m-4.5-2.6l9 5.2m0-5.2l-9 5.2m4.5-7.8v10.4", "1"),
        "block": ("m-3-3h6v6h-6z", "s"),
        "peak": ("m0-4.6l4.2 7.2h-8.4z", "^"),
        "gem": ("m0-4.6l4.6 4.6l-4.6 4.6l-4.6-4.6z", "D"),
        "drop": ("m0 4.6l4.2-7.2h-8.4z", "v"),
        "bar": ("m0-6v12", "|"),
        "hyphen": ("m-6 0h12", "_"),
        "fork": ("m0 0v-6m0 6l5 4m-5-4l-5 4", "2"),
    }
)
"""Mark → its outline about a point as an SVG path in pixels, and matplotlib's sign. Those of the
estimators lie in each other where they fall on one point, for all but the first are hollow."""

FILLED = ("dot", "block", "peak", "gem", "drop")
DASHES: tuple[tuple[float, ...], ...] = ((), (9.0, 3.0), (2.0, 3.0), (9.0, 3.0, 2.0, 3.0))
DASHED: tuple[float, ...] = (5.0, 4.0)
"""Of a line whose style is dashed, whatever its colour's stroke is."""


@dataclass(frozen=True)
class Stroke:
    """What tells a line apart without its colour: dashes in pixels, and a mark of `MARKS`."""

    dash: tuple[float, ...] = ()
    mark: str = ""


_STROKES: Mapping[Colour, Stroke] = {NAMED[TRUTH]: Stroke()} | {
    colour: Stroke(dash, mark)
    for colour, dash, mark in zip(
        (*list(NAMED.values())[1:], *OTHERS), cycle(DASHES), cycle(MARKS), strict=False
    )
}


def stroke_of(colour: Colour, style: Style = "line") -> Stroke:
    """Return the stroke of a line of a colour; the truth is a plain line."""
    found = _STROKES[colour]
    return Stroke(DASHED, found.mark) if style == "dashed" else found


def colours_of(figures: Iterable[Figure], first: Iterable[str] = ()) -> Mapping[str, Colour]:
    """Return a colour for every line name in figures: one name has one colour in all of them.

    A name that `NAMED` has not takes the first of `OTHERS` that no line beside it in a
    figure has; beyond them the colours repeat.

    Parameters
    ----------
    first : names that stand together before all figures
    """
    groups = [tuple(first), *(_names(figure) for figure in figures)]
    found: dict[str, Colour] = {}
    free = (*OTHERS, *list(NAMED.values())[1:])
    for name in dict.fromkeys(name for group in groups for name in group):
        beside = {found[n] for group in groups if name in group for n in group if n in found}
        beside |= {NAMED[n] for group in groups if name in group for n in group if n in NAMED}
        unused = [colour for colour in free if colour not in beside]
        found[name] = NAMED.get(name) or (unused[0] if unused else free[len(found) % len(free)])
    return MappingProxyType(found)


def _names(figure: Figure) -> Sequence[str]:
    return list(dict.fromkeys(line.name for panel in figure.panels for line in panel.lines))
