"""Colours and strokes of every drawing and of the report's page: one table, light and dark."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
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

    def band(self, theme: Theme) -> str:
        """Return the colour of this line's band, as ``rgba(…)``."""
        red, green, blue = (int(self.on(theme)[at : at + 2], 16) for at in (1, 3, 5))
        return f"rgba({red}, {green}, {blue}, {BAND_OPACITY[theme]})"


BAND_OPACITY: Mapping[Theme, float] = MappingProxyType({"light": 0.16, "dark": 0.24})

NAMED: Mapping[str, Colour] = MappingProxyType(
    {
        TRUTH: Colour("#16191d", "#f4f5f6"),
        "ekf": Colour("#0a5fb4", "#6cb2f5"),
        "ukf": Colour("#557a00", "#b2d84f"),
        "mhe-rti": Colour("#007a63", "#45d3b0"),
        "mhe": Colour("#c8420a", "#ff9655"),
        "mhe-sparse": Colour("#a1247d", "#f28bcd"),
        "mhe-ipopt": Colour("#6a4fc4", "#b7a4ff"),
        "fixed-weight": Colour("#8b6900", "#e3c34a"),
        "gyro-free": Colour("#00758c", "#4ecbe4"),
        "do-mpc": Colour("#5d6670", "#aab4bf"),
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
POINT_SIZE = 6.0


def colours_of(figures: Iterable[Figure]) -> Mapping[str, Colour]:
    """Return a colour for every line name in figures: one name has one colour in all of them.

    A name that `NAMED` has not takes the first of `OTHERS` that no line beside it in a
    figure has; beyond them the colours repeat.
    """
    groups = [_names(figure) for figure in figures]
    found: dict[str, Colour] = {}
    free = (*OTHERS, *NAMED.values())
    for name in dict.fromkeys(name for group in groups for name in group):
        beside = {found[n] for group in groups if name in group for n in group if n in found}
        beside |= {NAMED[n] for group in groups if name in group for n in group if n in NAMED}
        unused = [colour for colour in free if colour not in beside]
        found[name] = NAMED.get(name) or (unused[0] if unused else free[len(found) % len(free)])
    return MappingProxyType(found)


def _names(figure: Figure) -> Sequence[str]:
    return list(dict.fromkeys(line.name for panel in figure.panels for line in panel.lines))


def light_to_dark() -> Mapping[str, str]:
    """Return every colour string that a light drawing may hold → the same for a dark one."""
    lines = (*NAMED.values(), *OTHERS)
    return MappingProxyType(
        {colour.light: colour.dark for colour in (*PAGE.values(), *lines)}
        | {colour.band("light"): colour.band("dark") for colour in lines}
    )
