"""The report as one page that needs no network."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmark.figures.chart import chart
from benchmark.figures.figure import Figure, Line, Panel
from benchmark.figures.style import (
    FILLED,
    MARKS,
    PAGE,
    Colour,
    Stroke,
    Theme,
    colours_of,
    stroke_of,
)
from benchmark.report.broken import MOST
from benchmark.report.choice import figures_of
from benchmark.report.content import PAPERS_WORLD, SYMBOLS, TITLE, Content, ReportPart, slug
from benchmark.report.describe import describe
from benchmark.report.glance import axis_of
from benchmark.report.glossary import explained, glossary
from benchmark.report.in_short import headlines
from benchmark.report.matrix import LEVELS, SHOWN
from benchmark.report.numbers import count, interval, number, seconds
from benchmark.report.optimal import ABOUT_OPTIMUM, HEAD, OPTIMUM
from benchmark.report.sentences import (
    PAIR_SYMBOLS,
    answer_is_about,
    lead,
    notes,
    papers_world,
    refuted,
    verdict_sentence,
)
from benchmark.verdicts.judge import VERDICTS

if TYPE_CHECKING:
    from markupsafe import Markup

SHOWN_AT_ONCE = 12
"""Lines of a table that stands open when the page opens."""


@dataclass(frozen=True)
class LegendEntry:
    """A line's entry: its name, the number of its colour, its stroke, and whether it has a band."""

    name: str
    colour: int
    stroke: Stroke
    joined: bool
    band: bool


@dataclass(frozen=True, eq=False)
class Drawn:
    """A figure on the page.

    Parameters
    ----------
    id : of its element
    file_name : of a picture that is saved
    json : for ``chart.js``, safe within a script element
    """

    id: str
    figure: Figure
    file_name: str
    description: str
    legend: Sequence[LegendEntry]
    json: Markup


def page(content: Content) -> str:
    """Return the HTML."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup, escape

    environment = Environment(
        loader=PackageLoader("benchmark.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        number=number,
        seconds=seconds,
        count=count,
        slug=slug,
        breakable=lambda text: escape(text).replace("+", Markup("+<wbr>")),
        capitalised=lambda text: text[:1].upper() + text[1:],
        percent=lambda part: f"{number(100 * part)} %",
        explained=explained,
        dashes=_dashes,
        outline=outline,
    )
    estimators = _estimators(content)
    colours = colours_of([estimators, *(f for part in content.parts for f in part.figures)])
    script = _script(f"{_file('chart.js')}\n{_file('page.js')}")
    return environment.get_template("page.html.jinja").render(
        content=content,
        title=TITLE,
        lead=lead(content),
        answer_is_about=answer_is_about(content),
        headlines=headlines(content.answers),
        axis_of=axis_of,
        figures_of=figures_of,
        estimators=(legend := _legend(estimators, colours)),
        entries={entry.name: entry for entry in legend},
        filled=FILLED,
        glossary=glossary(),
        optimum_title=OPTIMUM,
        about_optimum=ABOUT_OPTIMUM,
        optimum_head=HEAD,
        papers_world=papers_world(content),
        papers_world_title=PAPERS_WORLD,
        verdict_sentence=verdict_sentence(content),
        refuted=refuted(content),
        notes=notes,
        figures={part.name: _drawn(part, colours) for part in content.parts},
        symbols=SYMBOLS,
        pair_symbols=PAIR_SYMBOLS,
        verdicts=VERDICTS,
        interval=interval,
        levels=LEVELS,
        steps=list(pairwise(LEVELS)),
        SHOWN=SHOWN,
        shown_at_once=SHOWN_AT_ONCE,
        most_broken=MOST,
        broken_tasks=lambda part: sum(len(row.seeds) for row in part.broken),
        style=Markup(_colour_rules(colours) + _file("page.css")),
        looks_json=script_json(_looks(colours)),
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


def _drawn(part: ReportPart, colours: Mapping[str, Colour]) -> list[Drawn]:
    return [
        Drawn(
            f"figure-{slug(part.name)}-{at + 1}",
            figure,
            slug(figure.key) or "figure",
            describe(figure),
            _legend(figure, colours),
            script_json(chart(figure, colours)),
        )
        for at, figure in enumerate(part.figures)
    ]


def _legend(figure: Figure, colours: Mapping[str, Colour]) -> list[LegendEntry]:
    found: dict[str, LegendEntry] = {}
    for line in (line for panel in figure.panels for line in panel.lines):
        stroke, number = stroke_of(colours[line.name], line.style), list(colours).index(line.name)
        first = found.setdefault(
            line.name, LegendEntry(line.name, number, stroke, line.style != "points", False)
        )
        if line.std is not None:
            found[line.name] = replace(first, band=True)
    return list(found.values())


def _estimators(content: Content) -> Figure:
    """Return a figure whose legend is that of the first picture."""
    names = [name for answer in content.answers for name in answer.matrix.estimators]
    nothing = np.empty(0)
    lines = [Line(name, nothing, nothing, style="points") for name in dict.fromkeys(names)]
    return Figure("glance", "", "", [Panel("", "", "", lines)])


def _looks(colours: Mapping[str, Colour]) -> list[dict[str, Any]]:
    """Return, by number of a colour, what ``chart.js`` must know of a line beside it."""
    strokes = {name: stroke_of(colour) for name, colour in colours.items()}
    return [
        {
            "name": name,
            "dash": _dashes(stroke),
            "dashed": _dashes(stroke_of(colours[name], "dashed")),
            "mark": outline(stroke),
            "filled": stroke.mark in FILLED,
        }
        for name, stroke in strokes.items()
    ]


def _dashes(stroke: Stroke) -> str:
    return " ".join(f"{length:g}" for length in stroke.dash)


def outline(stroke: Stroke) -> str:
    """Return the SVG path of a stroke's mark; empty where it has none."""
    return MARKS[stroke.mark][0] if stroke.mark else ""


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
