"""Sentences as of NMEA 0183: ``$VNIMU,+0.1,…*5A``, a tag, numbers, and a checksum behind them.

What the numbers of known tags are is written by their makers: VectorNav's VNIMU, VNYMR, VNQMR and
VNMAR (VN-100 User Manual, Async Outputs: gauss, m/s², rad/s). Those of others are columns
without names.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from recordings.foreign.sniffing import sniffed
from recordings.formats.serial_lines import CLOCK, LEAST_ALIKE, LineForm, clock_of, is_plain

_LINE = re.compile(
    rf"(?:{CLOCK})?\s*\$?(?P<tag>[A-Za-z][A-Za-z_]{{1,15}}\d?),"
    r"(?P<cells>[\d.,+\-eE \t]++)(?:\*[0-9A-Fa-f]{1,4})?\s*"
)
_ALIKE = 0.9
"""Part of the sentences that are of one unknown tag: of several, each is a sensor's."""
_MAG, _ACCEL, _GYRO = (
    tuple(f"{kind} {axis} [{unit}]" for axis in "xyz")
    for kind, unit in (("mag", "gauss"), ("accel", "m/s2"), ("gyro", "rad/s"))
)
TAGS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "VNIMU": (*_MAG, *_ACCEL, *_GYRO, "temperature", "pressure"),
        "VNYMR": ("yaw", "pitch", "roll", *_MAG, *_ACCEL, *_GYRO),
        "VNQMR": ("quat x", "quat y", "quat z", "quat w", *_MAG, *_ACCEL, *_GYRO),
        "VNMAR": (*_MAG, *_ACCEL, *_GYRO),
    }
)
"""Tag → what its numbers are."""


@dataclass(frozen=True)
class Sentences:
    """Sentences of one tag.

    Parameters
    ----------
    tag : that most have
    cells : behind it
    has_clock : whether a terminal put the time in front
    """

    tag: str
    cells: int
    has_clock: bool
    ends_lines: bool = True

    @property
    def names(self) -> tuple[str, ...] | None:
        """See `LineForm`."""
        clock = ("time",) if self.has_clock else ()
        known = TAGS.get(self.tag)
        if known is None or len(known) != self.cells:
            return (*clock, *(str(k) for k in range(1, self.cells + 1))) if clock else None
        return (*clock, *known)

    @property
    def said(self) -> tuple[str, ...]:
        """See `LineForm`."""
        return (f"sentences of {self.tag}",)

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`."""
        for line in lines:
            found = _LINE.fullmatch(line)
            cells = [] if found is None else _cells(found)
            if found is None or found["tag"] != self.tag or len(cells) != self.cells:
                yield line.replace(",", " ")
            else:
                yield ",".join([*([clock_of(found)] if self.has_clock else []), *cells])


def sentence_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of lines that are sentences of one tag, most of them; else None."""
    found = [one for line in lines if (one := _LINE.fullmatch(line)) is not None]
    if len(found) <= LEAST_ALIKE * sum(map(bool, map(str.strip, lines))):
        return None
    counted = Counter((one["tag"], len(_cells(one))) for one in found)
    (tag, cells), n = max(counted.items(), key=lambda one: (one[0][0] in TAGS, one[1]))
    if cells < len("xyz"):
        return None
    if tag not in TAGS and (n < _ALIKE * len(found) or is_plain(sniffed(lines))):
        return None
    return Sentences(tag, cells, sum(bool(clock_of(one)) for one in found) > LEAST_ALIKE * n)


def _cells(found: re.Match[str]) -> list[str]:
    return [cell.strip() for cell in found["cells"].strip().rstrip(",").split(",")]
