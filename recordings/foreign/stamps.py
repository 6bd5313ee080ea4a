"""The stamps of a table's rows: which column they are, their unit, and where they overflow.

A unit that a header writes is taken, and refused where it makes no sense of an inertial sensor.
Without one it is the unit in which stamps are an epoch of this century, or in which the rate is
one of inertial sensors, nearest to 100 Hz.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from models.arrays import Array
from models.errors import InputError
from recordings.foreign.column_names import kind_of_words, time_words
from recordings.foreign.header_units import KNOWN_UNITS, Unit, words_of
from recordings.foreign.source_table import SourceTable
from recordings.foreign.stamped_cells import Stamped, stamped_cells
from recordings.foreign.time_units import found_unit, preamble_rate_hz, usual_step
from recordings.foreign.told import counted
from recordings.formats.columns import loose_numbers

LARGE_S = 1e8
"""Stamps from here on are shifted to begin at zero: they count from an epoch."""
OVERFLOWS = (2.0**16, 2.0**24, 2.0**32, 2**32 / 1e3, 2**32 / 1e6)
"""Where counters begin again, in the unit of the stamps; micros() / 1000 too."""
DAY_NS = 86_400 * 10**9
LONGEST_STEPS = 20.0
"""An overflow leads to a step of so many usual ones at most."""
_PARTS = re.compile(r"(nano|n)\s?sec")
_COUNTERS = frozenset(("packetcounter", "samplecounter", "counter", "sample", "index", "frame"))
_COUNTER_OVERFLOW = 2.0**16


@dataclass(frozen=True, eq=False)
class Stamps:
    """When the rows of a table were captured.

    Parameters
    ----------
    header : of the column, or of the two, in a sentence
    raw : (n,) in the unit, whole numbers where the file has them; NaN where there is none
    unit : of `raw`
    given : how the unit is known: ``header``, ``pair``, ``option``, ``found``
    said : sentences on what was recognised
    repairs : sentences on what was mended
    """

    header: str
    raw: Stamped
    unit: Unit
    given: str
    said: tuple[str, ...] = ()
    repairs: tuple[str, ...] = ()

    @property
    def headers(self) -> tuple[str, ...]:
        """The columns."""
        return tuple(self.header.split(" and ")) if self.given == "pair" else (self.header,)

    @property
    def is_to_be_said(self) -> bool:
        """Whether what they are is no matter of course."""
        plain = self.header.casefold() == f"time_{self.unit.name}"
        return not (self.said or plain)

    def first_s(self) -> float:
        """Return the first stamp, s."""
        if len(self.raw) and np.isfinite(self.raw[0]):
            return float(self.raw[0]) * self.unit.factor
        known = np.isfinite(self.raw)
        return float(self.raw[known.argmax()]) * self.unit.factor if known.any() else 0.0

    def seconds(self, origin_s: float) -> Array:
        """Return the times (n,) from an origin, s, as exact as the file has them."""
        origin = origin_s / self.unit.factor
        if self.raw.dtype.kind == "i":
            return np.asarray((self.raw - round(origin)) * self.unit.factor, dtype=float)
        return np.asarray(self.raw * self.unit.factor - origin_s, dtype=float)


def stamp_headers(headers: Sequence[str]) -> list[str]:
    """Return the headers that may be those of times."""
    return [header for header in headers if time_words(header) is not None]


def stamps_of(
    table: SourceTable, where: str, *, header: str | None, unit: Unit | None, kind: str | None
) -> Stamps:
    """Return the stamps of a table's rows.

    Parameters
    ----------
    header : of their column, where somebody says it
    unit : of them, where somebody says it
    kind : of the readings that they are for, where a table has stamps for several

    Raises
    ------
    InputError
        If there are none, or their unit cannot be what it says.
    """
    frame, rate_hz = table.frame, preamble_rate_hz(table.preamble)
    headers = [header] if header is not None else list(candidates_for(table, kind))
    pair = _pair(headers)
    if pair is not None:
        seconds, rest = (loose_numbers(frame[name]) for name in pair)
        whole, part = (np.nan_to_num(column).astype(np.int64) for column in (seconds, rest))
        return Stamps(" and ".join(pair), whole * 10**9 + part, KNOWN_UNITS["ns"], "pair")
    usable: list[tuple[str, Stamped, bool]] = []
    for one in headers:
        stamped, texts = stamped_cells(frame[one])
        if stamped is not None:
            usable.append((one, stamped, texts))
    if not usable:
        return _counted(table, where, rate_hz, headers)
    name, raw, is_text = usable[0]
    if len(usable) > 1:
        name, raw, is_text = max(usable, key=lambda one: _quality(*one))
    if is_text:
        return _unwrapped(
            Stamps(name, raw, KNOWN_UNITS["ns"], "header", (f"times from {name}, dates",))
        )
    written = (time_words(name) or ("", None))[1]
    if unit is not None:
        stamps = Stamps(name, raw, unit, "option")
    elif written is not None:
        stamps = Stamps(name, raw, written, "header")
    else:
        stamps = Stamps(name, raw, found_unit(name, raw, rate_hz), "found")
    return _unwrapped(stamps)


def _quality(name: str, raw: Stamped, is_text: bool) -> tuple[float, bool, bool, bool, bool, int]:
    """Return how well a column serves as stamps: how often it advances, then how it is told."""
    known = raw[np.isfinite(raw)]
    steps = np.diff(known)
    advances = float((steps > 0).mean()) if len(steps) else 0.0
    words = words_of(name)
    return (
        round(advances, 1),
        not is_text,
        "system" not in words and "utc" not in words,
        "stamp" in words,
        (time_words(name) or ("", None))[1] is not None,
        -len(words),
    )


def candidates_for(table: SourceTable, kind: str | None) -> tuple[str, ...]:
    """Return the columns that may be the stamps of a kind of readings.

    Those of this kind are, where there are some, else those of none in particular.
    """
    headers = stamp_headers([str(name) for name in table.frame.columns])
    told = {header: kind_of_words(header) for header in headers}
    own = [header for header, named in told.items() if named is not None and named == kind]
    return tuple(own or [h for h, named in told.items() if named is None] or headers)


def _pair(headers: Sequence[str]) -> tuple[str, str] | None:
    """Return the columns of whole seconds and of the nanoseconds beside them, as ROS has them."""
    for rest in headers:
        if _PARTS.search(" ".join(words_of(rest))):
            for name in headers:
                if re.search(r"\bsecs?\b", " ".join(words_of(name))) and name != rest:
                    return name, rest
    return None


def _counted(
    table: SourceTable, where: str, rate_hz: float | None, headers: Sequence[str]
) -> Stamps:
    """Return stamps from a counter of samples and the rate that stands above the header."""
    frame = table.frame
    counters = [name for name in frame if "".join(words_of(str(name))) in _COUNTERS]
    if rate_hz is not None:
        name, numbers = "row", np.arange(len(frame), dtype=float)
        if counters:
            counts = loose_numbers(frame[counters[0]])
            if _counts_rows(counts):
                name, numbers = str(counters[0]), counts
        wraps = np.cumsum(np.diff(numbers, prepend=numbers[:1]) < -_COUNTER_OVERFLOW / 2)
        raw = numbers + wraps * _COUNTER_OVERFLOW
        return Stamps(
            name, raw, Unit(f"1/({rate_hz:g} Hz)", "s", 1 / rate_hz), "option",
            (f"times from {name} at the {rate_hz:g} Hz that stand above the header",),
        )  # fmt: skip
    named = f" ({', '.join(headers)} holds none)" if headers else ""
    raise InputError(
        f"{where}: no column of times{named}, expected one like time_s, or --columns "
        f'"time=NAME", or "time=100Hz" for rows at that rate'
    )


def _counts_rows(counts: Array) -> bool:
    """Whether most rows have a number of their own: Vicon's frames have several devices' rows."""
    return len(counts) < 2 or float(np.median(np.nan_to_num(np.diff(counts)))) > 0


def _unwrapped(stamps: Stamps) -> Stamps:
    """Return stamps that go on where a counter, or a day, began again."""
    raw = stamps.raw
    steps = np.diff(np.asarray(raw, dtype=float))
    back = np.flatnonzero(steps < 0)
    if not len(back):
        return stamps
    step = usual_step(np.asarray(raw, dtype=float))
    if step is None:
        return stamps
    moduli = (*OVERFLOWS, float(DAY_NS)) if stamps.unit.name == "ns" else OVERFLOWS
    added, wraps, modulus_found = np.zeros(len(raw)), 0, 0.0
    for at in back:
        for modulus in moduli:
            if 0 < steps[at] + modulus <= LONGEST_STEPS * step and raw[at] <= modulus * 1.01:
                added[at + 1 :] += modulus
                wraps, modulus_found = wraps + 1, modulus
                break
    if not wraps:
        return stamps
    whole = raw.dtype.kind == "i" and float(modulus_found).is_integer()
    mended = raw + (added.astype(np.int64) if whole else added)
    what = f"{counted(wraps, 'overflow')} of {stamps.header} at {modulus_found:.10g} undone"
    if modulus_found == DAY_NS:
        what = f"midnight passed {counted(wraps, 'time')} in {stamps.header}"
    return replace(stamps, raw=mended, repairs=(*stamps.repairs, what))
