"""Texts of people, put into other languages: at that border each is made harmless.

HTML has `html.escape`, and the report's templates escape by themselves.
"""

from __future__ import annotations

import re

from models.shown_text import one_line

_MARKDOWN = (("\\", "\\\\"), ("|", "\\|"), ("<", "\\<"), ("`", "\\`"), ("](", "]\\("))
"""What would end a cell, or begin HTML, code or a link → what shows it; the rest is readable."""


def in_comment(text: str) -> str:
    """Return a text for a line of a comment in C, or behind # in CMake: it ends neither."""
    return (
        one_line(text).replace("*/", "* /").replace("/*", "/ *").replace("??/", "?? /").rstrip("\\")
    )


def c_string(text: str) -> str:
    """Return a string of C, in its quotes."""
    encoded = text.encode("utf-8", "backslashreplace")
    # Three octal digits end by themselves; a question mark could begin a trigraph.
    return '"' + "".join(map(_character, encoded)) + '"'


def in_markdown(text: str) -> str:
    """Return a text for a line or a table's cell of Markdown."""
    text = one_line(" ".join(text.split()))
    for mark, safe in _MARKDOWN:
        text = text.replace(mark, safe)
    return text


def code_span(text: str) -> str:
    """Return a text as code within a line of Markdown: behind more backticks than it has."""
    text = one_line(text)
    ticks = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    space = " " if text.startswith("`") or text.endswith("`") else ""
    return f"{ticks}{space}{text}{space}{ticks}"


def _character(byte: int) -> str:
    is_plain = 32 <= byte < 127 and byte not in b'"\\?'
    return chr(byte) if is_plain else f"\\{byte:03o}"
