"""The templates of the report, for browsers and for terminals, and what both call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from benchmark.report import content, optimal
from benchmark.report.broken import MOST
from benchmark.report.in_short import headlines, in_short
from benchmark.report.matrix import SHOWN
from benchmark.report.numbers import count, interval, number, seconds
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
    from jinja2 import Template

_FILTERS = {
    "number": number,
    "seconds": seconds,
    "count": count,
    "slug": content.slug,
    "capitalised": lambda text: text[:1].upper() + text[1:],
    "percent": lambda part: f"{number(100 * part)} %",
}
_GLOBALS: dict[str, Any] = {
    "answer_is_about": answer_is_about,
    "broken_tasks": lambda part: sum(len(row.seeds) for row in part.broken),
    "headlines": headlines,
    "in_short": in_short,
    "interval": interval,
    "lead": lead,
    "most_broken": MOST,
    "notes": notes,
    "optimal": optimal,
    "pair_symbols": PAIR_SYMBOLS,
    "papers_world": papers_world,
    "papers_world_title": content.PAPERS_WORLD,
    "refuted": refuted,
    "SHOWN": SHOWN,
    "symbols": content.SYMBOLS,
    "title": content.TITLE,
    "verdict_sentence": verdict_sentence,
    "verdicts": VERDICTS,
}


def template(name: str, filters: dict[str, Any], **options: Any) -> Template:
    """Return a template of this folder, with filters and options of its language."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # slow to import

    environment = Environment(
        loader=PackageLoader("benchmark.report", "."),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        **options,
    )
    environment.filters.update(_FILTERS | filters)
    environment.globals.update(_GLOBALS)
    return environment.get_template(name)
