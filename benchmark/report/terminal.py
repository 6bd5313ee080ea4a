"""The report as text for terminals: Markdown without figures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby

from benchmark.report.content import Content
from benchmark.report.matrix import SHOWN, Cell
from benchmark.report.numbers import interval, number
from benchmark.report.templates import template
from models.escaped import code_span, in_markdown

REPORT, PRINTED = "report.md.jinja", "printed.md.jinja"
"""All of it, and what a run prints when it ends."""


class Markdown(str):
    """Text that is Markdown already."""

    __slots__ = ()


def terminal(content: Content, part: str = REPORT) -> str:
    """Return the Markdown; every label in it is escaped."""
    filters = {"as_code": lambda text: Markdown(code_span(text)), "head": _head}
    own = {"best": Markdown("`*`")}
    text = template(part, filters | {"figure": _figure, "cell": _cell}, finalize=_safe)
    return re.sub(r"\n{3,}", "\n\n", aligned(text.render(content=content, **own))).strip() + "\n"


def aligned(text: str) -> str:
    """Return a text whose tables have columns of even width."""
    found: list[str] = []
    for is_table, lines in groupby(text.split("\n"), lambda line: line.startswith("|")):
        if not is_table:
            found += lines
            continue
        head, _, *rows = (re.split(r"(?<!\\)\|", line)[1:-1] for line in lines)
        cells = [[cell.strip() for cell in row] for row in (head, *rows)]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        even = ["| " + " | ".join(map(str.ljust, row, widths)) + " |" for row in cells]
        found += [even[0], f"|{'|'.join('-' * (width + 2) for width in widths)}|", *even[1:]]
    return "\n".join(found)


def _safe(value: object) -> object:
    return value if isinstance(value, Markdown) else in_markdown(str(value))


def _head(names: Sequence[object]) -> Markdown:
    cells = "".join(f" {in_markdown(str(name))} |" for name in names)
    return Markdown(f"|{cells}\n|{'---|' * len(names)}")


def _cell(cell: Cell) -> str:
    if cell.state != SHOWN:
        return cell.state
    seeds = f", {cell.seeds} of {cell.of}" if cell.seeds < cell.of else ""
    return _figure(cell.median, cell.low, cell.high) + seeds + (" *" if cell.best else "")


def _figure(value: float, low: float, high: float) -> str:
    """Return ``0.2 (0.1 to 0.3)``."""
    ends = interval(low, high)
    return f"{number(value)} ({ends})" if ends else number(value)
