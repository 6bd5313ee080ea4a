"""Docstrings of the house, as Sphinx' numpy reader wants them.

Here a parameter stands as ``name : what it is``; a numpy docstring has its type there and what it
is below. Where it is said elsewhere (``name : see `that_function```), the reader gets what is said.
"""

import inspect
import re
import sys
from collections.abc import Iterator
from importlib import import_module
from itertools import zip_longest
from typing import Any

UNDERLINE = re.compile(r"^-{3,}$")
ENTRY = re.compile(r"^(\*{0,2}\w[\w., *]*?) : (.+)$")
ELSEWHERE = re.compile(r"^(?:(.*\S),? )?see `([\w.]+)`$")
BARS = re.compile(r"\|(\S[^|`]*)\|")
LISTS = {"Parameters", "Attributes", "Other Parameters"}


def entries(lines: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Yield (names, what they are) of the lists of a docstring, and ("", [line]) of the rest."""
    section, names, said = "", "", list[str]()
    for line, following in zip_longest(lines, lines[1:], fillvalue=""):
        if names and line.startswith(" "):
            said.append(line.strip())
            continue
        if names:
            yield names, said
        if UNDERLINE.match(following):
            section = line
        entry = ENTRY.match(line) if section in LISTS else None
        names, said = (entry[1], [entry[2]]) if entry else ("", [])
        if not entry:
            yield "", [line]
    if names:
        yield names, said


def found(name: str, module: str) -> Any:
    """Return what a docstring of a module names, or None."""
    inside = getattr(sys.modules[module], name, None)
    if inside is not None or "." not in name:
        return inside
    where, _, last = name.rpartition(".")
    return getattr(import_module(where), last, None)


def said_elsewhere(names: str, said: list[str], module: str) -> list[tuple[str, list[str]]]:
    """Return each of the names with what another docstring says of it, where this one refers."""
    match = ELSEWHERE.match(" ".join(said))
    thing = found(match[2], module) if match else None
    if match is None or thing is None:
        return [(names, said)]
    there = {
        name: text
        for several, text in entries((inspect.getdoc(thing) or "").splitlines())
        for name in several.split(", ")
    }
    asked = names.split(", ")
    if not all(name in there for name in asked):
        return [(names, said)]
    return [(name, there[name]) for name in asked]


def as_numpy(lines: list[str], module: str) -> list[str]:
    """Return the lines of a docstring with what a parameter is below its name."""
    written = list[str]()
    for names, said in entries(lines):
        if not names:
            written += said
            continue
        for name, text in said_elsewhere(names, said, module):
            written += [name, *(f"    {line}" for line in text)]
    return [BARS.sub(r"\\|\1\\|", line) for line in written]


def setup(app: Any) -> dict[str, bool]:
    """Read docstrings before napoleon does."""

    def read(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
        module = getattr(thing, "__module__", None)
        lines[:] = as_numpy(lines, module if module in sys.modules else "pen_mhe")

    app.connect("autodoc-process-docstring", read, priority=400)
    return {"parallel_read_safe": True}
