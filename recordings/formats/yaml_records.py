"""Records of YAML with a line of dashes between them, as ``ros2 topic echo`` prints messages::

    header:
      stamp:
        sec: 1700000000
    angular_velocity:
      x: 0.1
    ---

(docs.ros.org, ``ros2 topic echo``; ROS 1 writes ``secs`` and ``nsecs``). A key within a key is
joined by a point; lists, which are covariances, are left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from recordings.formats.serial_lines import LineForm

_KEY = re.compile(
    r"(?P<blanks> {0,40})(?P<key>[A-Za-z_]\w{0,60}):(?:\s+(?P<value>[^\s].{0,200}))?\s*"
)
_NUMBER = re.compile(r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?|nan", re.IGNORECASE)
_END = "---"
_LEAST_RECORDS = 2


@dataclass(frozen=True)
class YamlRecords:
    """Records of one kind.

    Parameters
    ----------
    names : of their numbers
    """

    names: tuple[str, ...]
    said: tuple[str, ...] = ("records of YAML, a row each",)
    ends_lines: bool = True

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`: a record that was cut off has empty cells."""
        for record in _records(lines):
            yield ",".join(record.get(name, "") for name in self.names)


def yaml_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of records of YAML, at least two of them whole; else None."""
    told = [line.rstrip() for line in lines if line.strip()]
    keys = sum(_KEY.fullmatch(line) is not None for line in told)
    if told.count(_END) < _LEAST_RECORDS or keys <= 0.5 * len(told):
        return None
    records = list(_records(told))
    names = max(map(tuple, records), key=len)
    return YamlRecords(names) if len(names) >= len("xyz") else None


def _records(lines: Iterable[str]) -> Iterator[dict[str, str]]:
    """Yield the numbers of each record by their keys."""
    record: dict[str, str] = {}
    above: list[tuple[int, str]] = []
    for line in lines:
        if line.rstrip() == _END:
            if record:
                yield record
            record, above = {}, []
            continue
        found = _KEY.fullmatch(line.rstrip())
        if found is None:
            continue
        depth = len(found["blanks"])
        while above and above[-1][0] >= depth:
            above.pop()
        above.append((depth, found["key"]))
        if found["value"] and _NUMBER.fullmatch(found["value"].strip()):
            record[".".join(key for _, key in above)] = found["value"].strip()
    if record:
        yield record
