"""Rows without stamps below when they begin and how fast they come, as Empatica's E4 writes them::

    1793714709.00, 1793714709.00, 1793714709.00
    32.000000, 32.000000, 32.000000
    -3,22,60

"The first row is the initial time of the session expressed as unix timestamp in UTC. The second
row is the sample rate expressed in Hz." (``info.txt`` in every export; ``ACC.csv`` is in 1/64 g.)
The rows are given stamps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from recordings.foreign.time_units import CENTURY_S
from recordings.formats.serial_lines import LineForm

_ABOVE = 2
_FASTEST_HZ = 2000.0
_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class StartAndRate:
    """Rows at a rate.

    Parameters
    ----------
    start_s : from 1970
    rate_hz : of the rows
    columns : of a row
    """

    start_s: float
    rate_hz: float
    columns: int
    ends_lines: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """See `LineForm`."""
        is_vector = self.columns == len(_AXES)
        numbered = tuple(str(k) for k in range(1, self.columns + 1))
        return ("time [s]", *(_AXES if is_vector else numbered))

    @property
    def said(self) -> tuple[str, ...]:
        """See `LineForm`."""
        return (f"rows at {self.rate_hz:g} Hz, as its first two say",)

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`."""
        for number, line in enumerate(lines):
            if number >= _ABOVE:
                yield f"{self.start_s + (number - _ABOVE) / self.rate_hz:.6f},{line.strip()}"


def start_and_rate_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of rows whose first two say when they begin, and their rate; else None."""
    above = [_numbers(line) for line in lines[:_ABOVE]]
    if len(lines) <= _ABOVE or not all(numbers and len(set(numbers)) == 1 for numbers in above):
        return None
    (start_s, *others), (rate_hz, *_) = above
    is_one = len(above[1]) == len(above[0]) == len(_numbers(lines[_ABOVE]))
    if is_one and CENTURY_S[0] < start_s < CENTURY_S[1] and 0 < rate_hz <= _FASTEST_HZ:
        return StartAndRate(start_s, rate_hz, len(others) + 1)
    return None


def _numbers(line: str) -> list[float]:
    try:
        return [float(cell) for cell in line.split(",")]
    except ValueError:
        return []
