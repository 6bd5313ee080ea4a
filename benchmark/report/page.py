"""The report as one page that needs no network."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from benchmark.figures.figure import Figure
from benchmark.figures.plotly_figure import plotly_figure, plotly_layout, plotly_text
from benchmark.figures.style import PAGE, Colour, Theme, colours_of, light_to_dark
from benchmark.report.broken import MOST
from benchmark.report.content import PAPERS_WORLD, SYMBOLS, TITLE, Content, ReportPart, slug
from benchmark.report.describe import describe
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
    """A line's entry: its name, how plotly knows it, number of its colour, stroke."""

    name: str
    group: str
    colour: int
    style: str
    band: bool


@dataclass(frozen=True, eq=False)
class Drawn:
    """A figure on the page.

    Parameters
    ----------
    id : of its element
    file_name : of a picture that is saved
    height : in pixels, before it is drawn
    json : for plotly, safe within a script element
    """

    id: str
    figure: Figure
    file_name: str
    description: str
    legend: Sequence[LegendEntry]
    height: int
    json: Markup


def page(content: Content) -> str:
    """Return the HTML."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup, escape
    from plotly.offline import get_plotlyjs

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
    )
    colours = colours_of(figure for part in content.parts for figure in part.figures)
    plotly_js, page_js = _script(get_plotlyjs()), _script(_file("page.js"))
    return environment.get_template("page.html.jinja").render(
        content=content,
        title=TITLE,
        lead=lead(content),
        answer_is_about=answer_is_about(content),
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
        dark_json=script_json(dict(light_to_dark())),
        plotly_js=Markup(plotly_js),
        page_js=Markup(page_js),
        script_hashes=Markup(" ".join(_hash(script) for script in (plotly_js, page_js))),
    )


def script_json(value: Any) -> Markup:
    """Return JSON that can stand within a script element: no ``<``, ``>`` or ``&`` in it."""
    from markupsafe import Markup

    text = json.dumps(value, allow_nan=False, separators=(",", ":"))  # ASCII only
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def _drawn(part: ReportPart, colours: Mapping[str, Colour]) -> list[Drawn]:
    found = []
    for at, figure in enumerate(part.figures):
        spec = plotly_figure(figure, colours)
        if figure.columns > 1:
            spec["narrow"] = plotly_layout(figure, columns=1)
        found.append(
            Drawn(
                f"figure-{slug(part.name)}-{at + 1}",
                figure,
                slug(figure.key) or "figure",
                describe(figure),
                _legend(figure, list(colours)),
                spec["layout"]["height"],
                script_json(spec),
            )
        )
    return found


def _legend(figure: Figure, names: Sequence[str]) -> list[LegendEntry]:
    found: dict[str, LegendEntry] = {}
    for line in (line for panel in figure.panels for line in panel.lines):
        band = line.std is not None or (line.name in found and found[line.name].band)
        style = found[line.name].style if line.name in found else line.style
        found[line.name] = LegendEntry(
            line.name, plotly_text(line.name), names.index(line.name), style, band
        )
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
