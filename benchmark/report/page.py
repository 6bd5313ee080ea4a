"""The report as one page that needs no network."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterable, Mapping
from functools import partial
from importlib import resources
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from benchmark.figures.band import band
from benchmark.figures.chart import chart
from benchmark.figures.figure import Figure
from benchmark.figures.style import FILLED, MARKS, PAGE, Colour, Theme, colours_of, stroke_of
from benchmark.report.choice import figures_of
from benchmark.report.content import Content
from benchmark.report.describe import describe
from benchmark.report.glance import axis_of
from benchmark.report.glossary import explained, glossary
from benchmark.report.matrix import LEVELS
from benchmark.report.templates import template

if TYPE_CHECKING:
    from markupsafe import Markup

SHOWN_AT_ONCE = 12
"""Lines of a table that stands open when the page opens."""

Look = dict[str, Any]
"""What a legend and ``chart.js`` must know of a line: name, number of its colour, dashes, mark."""


def page(content: Content) -> str:
    """Return the HTML."""
    from markupsafe import Markup, escape

    figures = [figure for part in content.parts for figure in part.figures]
    estimators = [name for answer in content.answers for name in answer.matrix.estimators]
    colours = colours_of(figures, first=estimators)
    looks = {name: _look(at, name, colour) for at, (name, colour) in enumerate(colours.items())}
    script = _script(f"{_file('chart.js')}\n{_file('page.js')}")
    filters = {
        "breakable": lambda text: escape(text).replace("+", Markup("+<wbr>")),
        "explained": explained,
    }
    return template("page.html.jinja", filters, autoescape=True).render(
        content=content,
        axis_of=axis_of,
        figures_of=figures_of,
        looks=looks,
        estimators=list(dict.fromkeys(estimators)),
        glossary=glossary(),
        describe=describe,
        legend=partial(_legend, looks=looks),
        chart_json=lambda figure: script_json(chart(figure, colours)),
        levels=LEVELS,
        steps=list(pairwise(LEVELS)),
        shown_at_once=SHOWN_AT_ONCE,
        style=Markup(_colour_rules(colours) + _file("page.css")),
        looks_json=script_json(list(looks.values())),
        script=Markup(script),
        script_hashes=Markup(_hash(script)),
    )


def script_json(value: Any) -> Markup:
    """Return JSON that can stand within a script element: no ``<``, ``>`` or ``&`` in it."""
    from markupsafe import Markup

    text = json.dumps(value, allow_nan=False, separators=(",", ":"))  # ASCII only
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def _look(number: int, name: str, colour: Colour) -> Look:
    stroke, dashed = stroke_of(colour), stroke_of(colour, "dashed")
    return {
        "name": name,
        "colour": number,
        "dash": _dashes(stroke.dash),
        "dashed": _dashes(dashed.dash),
        "mark": MARKS[stroke.mark][0] if stroke.mark else "",
        "filled": stroke.mark in FILLED,
    }


def _dashes(lengths: Iterable[float]) -> str:
    return " ".join(f"{length:g}" for length in lengths)


def _legend(figure: Figure, looks: Mapping[str, Look]) -> list[Look]:
    """Return the looks of a figure's lines, each with its style and whether it has a band."""
    found: dict[str, Look] = {}
    for line in (line for panel in figure.panels for line in panel.lines):
        first = found.get(line.name, looks[line.name] | {"style": line.style, "band": False})
        found[line.name] = first | {"band": first["band"] or band(line) is not None}
    return list(found.values())


def _colour_rules(colours: Mapping[str, Colour]) -> str:
    light, dark = _rules(colours, "light"), _rules(colours, "dark")
    return f"{light}\n@media screen and (prefers-color-scheme: dark) {{\n{dark}\n}}\n"


def _rules(colours: Mapping[str, Colour], theme: Theme) -> str:
    page = "; ".join(f"--{name}: {colour.on(theme)}" for name, colour in PAGE.items())
    lines = [
        f".colour-{at} {{ --line: {colour.on(theme)} }}"
        for at, colour in enumerate(colours.values())
    ]
    return "\n".join([f":root {{ {page} }}", *lines])


def _file(name: str) -> str:
    return (resources.files("benchmark.report") / name).read_text("utf-8")


def _script(text: str) -> str:
    if "</script" in text.lower():
        raise ValueError("a script that ends its own element cannot be embedded")
    return text


def _hash(script: str) -> str:
    # As a browser reads it: with line ends of one kind.
    read = script.replace("\r\n", "\n").replace("\r", "\n")
    digest = hashlib.sha256(read.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
