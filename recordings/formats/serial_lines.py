"""Lines that a person reads: ``ax:0.12 ay:-0.03``, ``Accel X: 0.1 Y: 0.2 Z: 9.8 m/s^2``.

So print sketches to a serial monitor, which may put the time of day in front of each line
(Arduino's ``14:07:02.250 -> 0.1,0.2``). Such a line is rewritten as a row of cells: its numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from recordings.foreign.column_names import kind_of_words
from recordings.foreign.header_units import split_header, unit_of
from recordings.foreign.sniffing import Dialect, sniffed

LEAST_ALIKE = 0.5
"""Part of the lines that name the same, from which they are rows."""
LEAST_KEYS = 2
_TIME_OF_DAY = r"\d{1,2}:\d{2}:\d{2}(?:\.\d{1,9})?"
_DIGITS = r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?"
_NUMBER = re.compile(
    rf"(?<![\w.:^])(?:(?P<stamp>{_TIME_OF_DAY})|{_DIGITS})(?![\w:])"
    rf"|(?<=[A-Za-z]:){_DIGITS}(?![\w:])"
)
_KEY = re.compile(r"[A-Za-z_][^:=]{0,40}[:=]\s*$|[A-Za-z_]\s*[:=]\s*$")
_WORD = re.compile(r"[A-Za-z]")
_DATE = r"\d{4}[-/.]\d{1,2}[-/.]\d{1,2}"
CLOCK = (
    rf"\s*(?:(?P<clock>{_TIME_OF_DAY})\s*->|\[(?P<bracketed>(?:{_DATE}[ T])?{_TIME_OF_DAY})\])\s?"
)
"""The time that a terminal puts in front: Arduino's, and those that put it in brackets."""
_PREFIX = re.compile(rf"{CLOCK}(?P<rest>.*)", re.DOTALL)
_ESP_LOG = re.compile(r"^[EWIDV] \($")
_AXES = "xyzw"
_OPEN = " \t,;|>"
_OPENED = re.compile(r"(?<=[:=])\s*\($")


class LineForm(Protocol):
    """How lines become rows of cells."""

    @property
    def names(self) -> tuple[str, ...] | None:
        """The columns' names; None where nothing names them."""

    @property
    def said(self) -> tuple[str, ...]:
        """Sentences on what such lines are taken for."""

    @property
    def ends_lines(self) -> bool:
        """Whether every line ends where it says so, so that a last one without was cut off."""

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """Yield rows of cells; a line that is part of none as text without commas."""


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
    said: tuple[str, ...] = ()
    ends_lines: bool = False

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`."""
        for line in lines:
            labels, numbers, _ = split_line(line)
            yield ",".join(numbers) if labels == self.labels else line.replace(",", " ")


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
    said: tuple[str, ...] = ()
    ends_lines: bool = False

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`."""
        for line in lines:
            found = _PREFIX.fullmatch(line)
            yield f"{clock_of(found)}{self.delimiter}{found['rest']}" if found else line


def labelled_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of lines of numbers with names, or the time of day, in front; else None."""
    form = _labelled(lines)
    if form is not None:
        dialect = sniffed(lines)
        if is_plain(dialect):
            return None
        keys = sum(_KEY.search(label) is not None for label in form.labels)
        if keys >= LEAST_KEYS or sum(map(_names_a_kind, form.labels)) >= LEAST_KEYS:
            return form
    found = [_PREFIX.fullmatch(line) for line in lines]
    rests = [one["rest"] for one in found if one is not None]
    if len(rests) > LEAST_ALIKE * len(lines):
        dialect = sniffed(rests)
        if dialect is not None:
            names = None if dialect.header is None else ("time", *dialect.header)
            return Stamped(dialect.delimiter, names)
    return None


def is_plain(dialect: Dialect | None) -> bool:
    """Whether lines are a table with a header as they stand."""
    return dialect is not None and dialect.header is not None


def _labelled(lines: Sequence[str]) -> Labelled | None:
    split = [split_line(line) for line in lines]
    found = [labels for labels, _, _ in split]
    named = [labels for labels in found if sum(map(bool, labels)) >= LEAST_KEYS]
    if not named:
        return None
    most = max(set(named), key=named.count)
    told = [labels for labels in found if labels]
    if named.count(most) < LEAST_ALIKE * len(told):
        return None
    end = next(end for labels, _, end in split if labels == most)
    return Labelled(names_of(most, end), most)


def clock_of(found: re.Match[str]) -> str:
    """Return the time that `CLOCK` found in front of a line; nothing where it is optional."""
    return found["clock"] or found["bracketed"] or ""


def split_line(line: str) -> tuple[tuple[str, ...], list[str], str]:
    """Return what stands in front of each number, nothing where that has no letter, these, and
    what stands behind the last.
    """
    labels, numbers, at = [], [], 0
    for found in _NUMBER.finditer(line):
        text = line[at : found.start()].lstrip(_OPEN + "])").rstrip(_OPEN + "[")
        text = _OPENED.sub("", text)
        labels.append(("time:" if found["stamp"] else "") if not _WORD.search(text) else text)
        numbers.append(found[0])
        at = found.end()
    return tuple(labels), numbers, line[at:].strip()


def names_of(labels: Sequence[str], end: str) -> tuple[str, ...]:
    """Return a name for each number: an axis alone, or no word, belongs to the words before."""
    names: list[str] = []
    stem, axis, first = "", 0, 0
    for label in labels:
        words = re.sub(r"[:=\s]+", " ", label).strip()
        unit, _, rest = words.partition(" ")
        if names and unit_of(unit) is not None and (rest or len(unit) > 1):  # of those in front
            names[first:] = [f"{name} [{unit}]" for name in names[first:]]
            words = rest
        if not words and not stem and names and names[-1] == "w":  # of ``a=(…) w=(…)``
            stem = "w"
        if _ESP_LOG.fullmatch(label):
            names.append("time [ms]")
            stem, first = "", len(names)
        elif words.casefold() in tuple(_AXES) and stem and not (words == "w" and axis):
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
    words = split_header(label)[0].split()
    return bool(words) and kind_of_words(words[-1]) is not None
