"""Lines of i2cdevlib's raw examples: ``a/g:`` and six counts, ``a/g/m:`` and nine, by tabs.

``MPU6050_raw.ino`` and ``MPU9150_raw.ino`` of github.com/jrowberg/i2cdevlib print them, without
times. ``initialize()`` sets the smallest ranges, 2 g and 250 deg/s, of 16384 counts per g and 131
per deg/s (MPU-6000/MPU-6050 Product Specification, 6.1 and 6.2).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from recordings.formats.serial_lines import LEAST_ALIKE, LineForm

_LINE = re.compile(
    r"(?:(?P<clock>\d{1,2}:\d{2}:\d{2}(?:\.\d{1,9})?) -> )?"
    r"(?P<what>a/g(?:/m)?):(?P<counts>(?:[ \t]+-?\d{1,5})+)\s*"
)
_INERTIAL = ("ax", "ay", "az", "gx", "gy", "gz")
_NAMES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"a/g": _INERTIAL, "a/g/m": (*_INERTIAL, "mx", "my", "mz")}
)
_SAID = (
    "i2cdevlib's counts, of an MPU-6050 at the ranges that it sets: 16384 per g and 131 "
    "per deg/s, unless the readings say others or --units accel=g/8192 does"
)


@dataclass(frozen=True)
class I2cdev:
    """Lines of one of the raw examples.

    Parameters
    ----------
    what : stands in front of the counts: ``a/g``
    has_clock : whether a serial monitor put the time of day in front
    """

    what: str
    has_clock: bool
    said: tuple[str, ...] = (_SAID,)
    ends_lines: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """See `LineForm`."""
        return (*(["time"] if self.has_clock else []), *_NAMES[self.what])

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`: a line with another number of counts was cut off."""
        for line in lines:
            found = _LINE.fullmatch(line)
            cells = [] if found is None else _cells(found)
            is_row = found is not None and found["what"] == self.what
            yield (
                ",".join(cells)
                if is_row and len(cells) == len(self.names)
                else line.replace(",", " ").replace("\t", " ")
            )


def i2cdev_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of lines that one of the raw examples printed; else None."""
    found = [one for line in lines if (one := _LINE.fullmatch(line)) is not None]
    if len(found) <= LEAST_ALIKE * sum(map(bool, map(str.strip, lines))):
        return None
    of_clock = sum(one["clock"] is not None for one in found)
    whats = [one["what"] for one in found]
    return I2cdev(max(_NAMES, key=whats.count), of_clock > LEAST_ALIKE * len(found))


def _cells(found: re.Match[str]) -> list[str]:
    return [*([found["clock"]] if found["clock"] else []), *found["counts"].split()]
