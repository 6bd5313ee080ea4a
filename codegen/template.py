"""Files of an export in which some words are put in."""

from __future__ import annotations

import string
from importlib import resources


class AtTemplate(string.Template):
    """Words stand behind @, of which C and CMake have none."""

    delimiter = "@"


def filled(template: str, **words: str) -> str:
    """Return a file of codegen/templates with its words put in; all must be given."""
    text = (resources.files("codegen") / "templates" / template).read_text("utf-8")
    return AtTemplate(text).substitute(words)
