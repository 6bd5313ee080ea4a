"""InfluxDB's line protocol: ``imu,device=pen ax=0.1,ay=0.2 1700000000000000000``.

A measurement, tags, a blank, fields with commas between them, a blank, and a stamp, in ns where
nothing else was asked for (docs.influxdata.com, Line protocol reference).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from recordings.formats.serial_lines import LEAST_ALIKE, LineForm

_NUMBER = r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?"
_FIELD = re.compile(rf"([^=,\s]{{1,60}})=({_NUMBER})[iu]?")
_KEYED = rf"[^\s=,]{{1,60}}+={_NUMBER}[iu]?"
_LINE = re.compile(
    r"\s*[^\s,=#]{1,60}(?:,[^\s,=]{1,60}=[^\s,]{1,60})*"
    rf"[ ](?P<fields>{_KEYED}(?:,{_KEYED})+)[ ](?P<stamp>\d{{9,20}})\s*"
)


@dataclass(frozen=True)
class Influx:
    """Lines of one measurement.

    Parameters
    ----------
    keys : of their fields
    """

    keys: tuple[str, ...]
    said: tuple[str, ...] = ("InfluxDB's line protocol",)
    ends_lines: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """See `LineForm`."""
        return ("time", *self.keys)

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`."""
        for line in lines:
            found = _LINE.fullmatch(line)
            if found is None:
                yield line.replace(",", " ")
            else:
                fields = dict(_FIELD.findall(found["fields"]))
                yield ",".join([found["stamp"], *(fields.get(key, "") for key in self.keys)])


def influx_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of lines of InfluxDB's protocol, most of them; else None."""
    found = [one["fields"] for line in lines if (one := _LINE.fullmatch(line)) is not None]
    if len(found) <= LEAST_ALIKE * sum(map(bool, map(str.strip, lines))):
        return None
    counted = Counter(key for fields in found for key, _ in _FIELD.findall(fields))
    return Influx(tuple(counted))
