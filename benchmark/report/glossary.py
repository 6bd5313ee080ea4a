"""Words that the report explains where a reader touches them: ``terms.toml`` has them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from markupsafe import Markup


@cache
def glossary() -> Mapping[str, tuple[list[str], str]]:
    """Return anchor → the words that a term is found by, the first as its name, and its meaning."""
    text = (resources.files("benchmark.report") / "terms.toml").read_text("utf-8")
    return {
        f"term-{key}": (entry["words"], " ".join(entry["says"].split()))
        for key, entry in tomllib.loads(text).items()
    }


def explained(text: object) -> Markup:
    """Return a text whose terms lead to what they mean, each where it stands first."""
    from markupsafe import Markup, escape

    anchors = {word: anchor for anchor, (words, _) in glossary().items() for word in words}
    longest_first = sorted(map(re.escape, anchors), key=len, reverse=True)
    seen: set[str] = set()

    def linked(found: re.Match[str]) -> str:
        if anchors[found[0]] in seen:
            return found[0]
        seen.add(anchors[found[0]])
        return f'<a class="term" href="#{anchors[found[0]]}">{found[0]}</a>'

    pattern = rf"(?<![\w-])(?:{'|'.join(longest_first)})(?![\w-])"
    return Markup(re.sub(pattern, linked, str(escape(text))))
