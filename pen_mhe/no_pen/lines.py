"""A pen file as tables of keys, each with a comment that says where its value comes from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from models.arrays import Array

MEASURED, ASSUMED, TOLD = "measured", "assumed", "told"
DIGITS = 6


@dataclass(frozen=True)
class PenLine:
    """A key of a pen file.

    Parameters
    ----------
    key, value : as in TOML; numbers are rounded to `DIGITS`
    origin : `MEASURED`, `ASSUMED` or `TOLD`; nothing for a name
    why : how it was measured, or why it is assumed
    """

    key: str
    value: Any
    origin: str = ""
    why: str = ""

    def text(self) -> str:
        """Return the line."""
        comment = ": ".join(part for part in (self.origin, self.why) if part)
        return f"{self.key} = {_toml(self.value)}" + (f"  # {comment}" if comment else "")


def pen_text(head: Iterable[str], tables: Mapping[str, Iterable[PenLine]]) -> str:
    """Return a pen file.

    Parameters
    ----------
    head : comments that it begins with
    tables : name → lines; the first table, without a name, is the top level
    """
    lines = [f"# {line}".rstrip() for line in head]
    for name, entries in tables.items():
        lines += ["", f"[{name}]"] if name else [""]
        lines += [entry.text() for entry in entries]
    return "\n".join(lines) + "\n"


def rounded(values: Array) -> list[float]:
    """Return numbers as they are written."""
    return [float(f"{float(value):.{DIGITS}g}") for value in values]


def _toml(value: Any) -> str:
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, bool | int):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return repr(float(f"{float(value):.9g}"))
