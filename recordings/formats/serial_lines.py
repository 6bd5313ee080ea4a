"""Lines that a person reads: ``ax:0.12 ay:-0.03``, ``Accel X: 0.1 Y: 0.2 Z: 9.8 m/s^2``.

So print sketches to a serial monitor, which may put the time of day in front of each line
(Arduino's ``14:07:02.250 -> 0.1,0.2``). Such a line is rewritten as a row of cells: its numbers.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO, Protocol

from recordings.foreign.column_names import kind_of_words
from recordings.foreign.header_units import unit_of
from recordings.foreign.sniffing import Dialect, sniffed
from recordings.formats.unpacked import spooled

LEAST_ALIKE = 0.5
"""Part of the lines that name the same, from which they are rows."""
LEAST_KEYS = 2
_TIME_OF_DAY = r"\d{1,2}:\d{2}:\d{2}(?:\.\d{1,9})?"
_DIGITS = r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?"
_NUMBER = re.compile(
    rf"(?<![\w.:])(?:(?P<stamp>{_TIME_OF_DAY})|{_DIGITS})(?![\w:])"
    rf"|(?<=[A-Za-z]:){_DIGITS}(?![\w:])"
)
_KEY = re.compile(r"[A-Za-z_][^:=]{0,40}[:=]\s*$|[A-Za-z_]\s*[:=]\s*$")
_WORD = re.compile(r"[A-Za-z]")
_PREFIX = re.compile(rf"\s*({_TIME_OF_DAY})\s*->\s?(.*)", re.DOTALL)
_ESP_LOG = re.compile(r"^[EWIDV] \($")
_AXES = "xyzw"


class LineForm(Protocol):
    """How lines become rows of cells."""

    @property
    def names(self) -> tuple[str, ...] | None:
        """The columns' names; None where nothing names them."""

    def row(self, line: str) -> str:
        """Return a line as cells; a line that is no row as text without commas."""


@dataclass(frozen=True)
class Labelled:
    """Lines of numbers with their names in front.

    Parameters
    ----------
    names : of the numbers
    labels : what stands in front of each
    """

    names: tuple[str, ...]
    labels: tuple[str, ...]

    def row(self, line: str) -> str:
        """See `LineForm`."""
        labels, numbers, _ = _split(line)
        return ",".join(numbers) if labels == self.labels else line.replace(",", " ")


@dataclass(frozen=True)
class Stamped:
    """Rows of cells with the time of day in front.

    Parameters
    ----------
    delimiter : between cells
    names : of the columns, the time first
    """

    delimiter: str
    names: tuple[str, ...] | None

    def row(self, line: str) -> str:
        """See `LineForm`."""
        found = _PREFIX.fullmatch(line)
        return f"{found[1]}{self.delimiter}{found[2]}" if found else line


def line_form(lines: Sequence[str]) -> LineForm | None:
    """Return how lines, the first of a text, are to be rewritten; None where they are rows."""
    form = _labelled(lines)
    if form is not None:
        dialect = sniffed(lines)
        if _is_plain(dialect):
            return None
        keys = sum(_KEY.search(label) is not None for label in form.labels)
        if keys >= LEAST_KEYS or sum(map(_names_a_kind, form.labels)) >= LEAST_KEYS:
            return form
    found = [_PREFIX.fullmatch(line) for line in lines]
    rests = [one[2] for one in found if one is not None]
    if len(rests) > LEAST_ALIKE * len(lines):
        dialect = sniffed(rests)
        if dialect is not None:
            names = None if dialect.header is None else ("time", *dialect.header)
            return Stamped(dialect.delimiter, names)
    return None


def rewritten(file: BinaryIO, form: LineForm) -> BinaryIO:
    """Return the rest of a text in a form of lines, at its beginning."""
    found = spooled()
    for line in file:
        text = line.decode("utf-8", "replace").rstrip("\r\n")
        found.write(form.row(text).encode() + b"\n")
    found.seek(0)
    return found


def _is_plain(dialect: Dialect | None) -> bool:
    """Whether lines are a table with a header as they stand."""
    return dialect is not None and dialect.header is not None


def _labelled(lines: Sequence[str]) -> Labelled | None:
    split = [_split(line) for line in lines]
    found = [labels for labels, _, _ in split]
    named = [labels for labels in found if sum(map(bool, labels)) >= LEAST_KEYS]
    if not named:
        return None
    most = max(set(named), key=named.count)
    told = [labels for labels in found if labels]
    if named.count(most) < LEAST_ALIKE * len(told):
        return None
    end = next(end for labels, _, end in split if labels == most)
    return Labelled(_names(most, end), most)


def _split(line: str) -> tuple[tuple[str, ...], list[str], str]:
    """Return what stands in front of each number, nothing where that has no letter, these, and
    what stands behind the last.
    """
    labels, numbers, at = [], [], 0
    for found in _NUMBER.finditer(line):
        text = line[at : found.start()].strip(" \t,;|>")
        labels.append(("time:" if found["stamp"] else "") if not _WORD.search(text) else text)
        numbers.append(found[0])
        at = found.end()
    return tuple(labels), numbers, line[at:].strip()


def _names(labels: Sequence[str], end: str) -> tuple[str, ...]:
    """Return a name for each number: an axis alone, or no word, belongs to the words before."""
    names: list[str] = []
    stem, axis, first = "", 0, 0
    for label in labels:
        words = re.sub(r"[:=\s]+", " ", label).strip()
        unit, _, rest = words.partition(" ")
        if names and unit_of(unit) is not None and (rest or len(unit) > 1):  # of those in front
            names[first:] = [f"{name} [{unit}]" for name in names[first:]]
            words = rest
        if _ESP_LOG.fullmatch(label):
            names.append("time [ms]")
            stem, first = "", len(names)
        elif words.casefold() in tuple(_AXES) and stem:
            names.append(f"{stem} {words}")
        elif _WORD.search(words):
            stem, _, last = words.rpartition(" ")
            stem = stem if last.casefold() in tuple(_AXES) else words
            axis, first = 0, len(names)
            names.append(words)
        elif stem and axis < len(_AXES) - 1:
            if axis == 0:
                names[-1] = f"{stem} x"
            axis += 1
            names.append(f"{stem} {_AXES[axis]}")
        else:
            names.append("")
    if names and unit_of(end) is not None:
        names[first:] = [f"{name} [{end}]" for name in names[first:]]
    return tuple(name.strip(" ()") for name in names)


def _names_a_kind(label: str) -> bool:
    words = label.split()
    return bool(words) and kind_of_words(words[-1]) is not None
