"""Texts from elsewhere in our sentences: one line, printable, and not longer than people read."""

from __future__ import annotations

LONGEST_VALUE = 200
"""Characters of a value in a message; the rest is cut off."""
LONGEST_SENTENCE = 3000
"""Characters of a whole message: a list of what was expected may be long."""


def one_line(text: str, most: int = LONGEST_SENTENCE) -> str:
    """Return a text as one printable line.

    Line breaks and tabs become blanks; what else a terminal would obey, or a text cannot encode,
    is spelt as in a string of Python.

    Parameters
    ----------
    most : characters that are kept; of a longer text the end goes, and ``…`` stands there
    """
    if len(text) > most:
        text = text[: most - 1] + "…"
    if text.isprintable():
        return text
    text = " ".join(text.split())
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def short(name: object) -> str:
    """Return a name or a text of somebody's file for a message: one line, `LONGEST_VALUE` long."""
    return one_line(name, LONGEST_VALUE) if isinstance(name, str) else value_text(name)


def value_text(value: object) -> str:
    """Return a value of somebody's file for a message: its `repr`, cut to `LONGEST_VALUE`."""
    try:
        # Of a long text the beginning is enough, and quicker to spell.
        start = value[: LONGEST_VALUE + 1] if isinstance(value, str) else value
        return one_line(repr(start), LONGEST_VALUE)
    except (ValueError, RecursionError):  # more digits, or deeper, than Python spells
        return f"a {type(value).__name__} that is too large to show"
