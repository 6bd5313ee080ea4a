"""Several lines an instant, as Adafruit's examples print them::

    Acceleration X: 0.12, Y: 0.30, Z: 9.80 m/s^2
    Rotation X: 0.01, Y: 0.00, Z: 0.02 rad/s
    Temperature: 28.14 degC

So do ``basic_readings.ino`` of github.com/adafruit/Adafruit_MPU6050 and, with ``Gyro X:`` and in
Python, ``lsm6ds_lsm6dsox_simpletest.py`` of github.com/adafruit/Adafruit_CircuitPython_LSM6DS.
They become one row, which begins where a line of the first kind stands.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from recordings.foreign.column_names import ACCELEROMETER, kind_of_words
from recordings.formats.serial_lines import LEAST_ALIKE, LineForm, names_of, split_line

_TIME = "time:"
_ALIKE = 0.8
"""Part of the most frequent kind of line that another has, from which it belongs to an instant."""
_Kind = tuple[tuple[str, ...], str]
"""What stands in front of a line's numbers, and behind the last."""


@dataclass(frozen=True)
class Block:
    """Lines that are one instant.

    Parameters
    ----------
    kinds : of line, in order; an instant begins with the first
    """

    kinds: tuple[_Kind, ...]
    ends_lines: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """See `LineForm`."""
        named = [names_of(labels, end) for labels, end in self.kinds]
        return tuple(
            name
            for k, names in enumerate(named)
            for name, label in zip(names, self.kinds[k][0], strict=True)
            if k == 0 or label != _TIME
        )

    @property
    def said(self) -> tuple[str, ...]:
        """See `LineForm`."""
        first = self.names[1 if self.kinds[0][0][0] == _TIME else 0]
        return (f"{len(self.kinds)} lines an instant, the first that of {first}",)

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`: of an instant that was cut, cells are empty."""
        place = {kind: k for k, kind in enumerate(self.kinds)}
        cells: dict[int, list[str]] = {}
        for line in lines:
            kind, numbers = _kind(line)
            k = place.get(kind)
            if k == 0 and cells:
                yield self._row(cells)
                cells = {}
            if k is None or k in cells or (k and not cells):
                if line.strip():
                    yield line.replace(",", " ")
            else:
                cells[k] = numbers
        if cells:
            yield self._row(cells)

    def _row(self, cells: dict[int, list[str]]) -> str:
        found: list[str] = []
        for k, (labels, _) in enumerate(self.kinds):
            numbers = cells.get(k, [""] * len(labels))
            found += [
                n for n, label in zip(numbers, labels, strict=True) if not k or label != _TIME
            ]
        return ",".join(found)


def block_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of lines of which several are an instant; else None.

    An instant begins below an empty line; without any, with the accelerometer.
    """
    if sum(":" in line or "=" in line for line in lines) < 2:
        return None
    kinds = [_kind(line)[0] for line in lines]
    counted = Counter(kind for kind in kinds if _is_labelled(kind[0]))
    if not counted:
        return None
    most = max(counted.values())
    chosen = [kind for kind, n in counted.items() if n >= max(2, _ALIKE * most)]
    told = sum(bool(line.strip()) for line in lines)
    if len(chosen) < 2 or sum(counted[kind] for kind in chosen) < LEAST_ALIKE * told:
        return None
    if not any(len(labels) >= len("xyz") and _names_a_kind(labels) for labels, _ in chosen):
        return None
    gaps = [not line.strip() for line in lines]
    below = Counter(kind for kind, gap in zip(kinds[1:], gaps, strict=False) if gap)
    first = max(chosen, key=lambda kind: (below[kind], _names_a_kind(kind[0]) == ACCELEROMETER))
    start = kinds.index(first)
    after = [kind for kind in kinds[start:] if kind in chosen]
    return Block(tuple(dict.fromkeys(after)))


def _kind(line: str) -> tuple[_Kind, list[str]]:
    labels, numbers, end = split_line(line)
    return (labels, end), numbers


def _is_labelled(labels: Sequence[str]) -> bool:
    """Whether numbers stand behind names with colons, but for a time of day."""
    named = [label for label in labels if label != _TIME]
    return bool(named) and all(label.endswith((":", "=")) for label in named)


def _names_a_kind(labels: Sequence[str]) -> str | None:
    first = next(label for label in labels if label != _TIME)
    return kind_of_words(first)
