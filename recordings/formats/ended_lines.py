"""Rows that end in a semicolon, with commas or blanks between cells: ``33,1000,-0.69,12.6,0.5;``.

So do WISDM's data (cis.fordham.edu/wisdm), and sketches that print rows of a MATLAB matrix.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from recordings.formats.serial_lines import LEAST_ALIKE, LineForm

_END = ";"


@dataclass(frozen=True)
class EndedRows:
    """Rows without what ends each."""

    names: tuple[str, ...] | None = None
    said: tuple[str, ...] = ()
    ends_lines: bool = False

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`."""
        for line in lines:
            yield line.rstrip().removesuffix(_END)


def ended_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of rows that end in the only semicolon of each; else None."""
    told = [line.rstrip() for line in lines if line.strip()]
    ended = [line for line in told if line.endswith(_END) and line.count(_END) == 1]
    return EndedRows() if len(ended) > LEAST_ALIKE * len(told) else None
