"""Lines of Teleplot, a number each: ``>accel_x:1627551892437:0.12§g``.

``>name:value`` or ``>name:stamp:value``, stamps in ms, several of the two parted by semicolons,
behind them ``§unit`` and ``|flags``, of which ``xy`` and ``t`` are no numbers in time
(github.com/nesnes/teleplot, README). They become rows of a name, a stamp and a value.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from recordings.formats.serial_lines import LEAST_ALIKE, LineForm

_NUMBER = r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?"
_ONE = rf"(?:{_NUMBER}:)?{_NUMBER}"
_LINE = re.compile(
    rf"\s*>\s*(?P<name>[^:;,>|§]{{1,60}}):(?P<numbers>{_ONE}(?:;{_ONE})*);?"
    r"(?:§(?P<unit>[^|]{0,20}))?(?:\|(?P<flags>[\w,]{0,20}))?\s*"
)
_NO_NUMBERS = frozenset(("xy", "t", "3D"))


@dataclass(frozen=True)
class Teleplot:
    """Lines of a number each.

    Parameters
    ----------
    is_stamped : whether their stamps are in them
    """

    is_stamped: bool
    said: tuple[str, ...] = ("lines of Teleplot",)
    ends_lines: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """See `LineForm`."""
        return ("name", "time [ms]", "value") if self.is_stamped else ("name", "value")

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`."""
        for line in lines:
            found = _LINE.fullmatch(line)
            if found is None or found["flags"] in _NO_NUMBERS:
                yield line.replace(",", " ")
                continue
            unit = f" [{found['unit'].replace(',', ' ')}]" if found["unit"] else ""
            for one in found["numbers"].split(";"):
                yield f"{found['name']}{unit},{one.replace(':', ',')}"


def teleplot_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of lines that Teleplot takes; else None."""
    found = [one for line in lines if (one := _LINE.fullmatch(line)) is not None]
    if len(found) <= LEAST_ALIKE * sum(map(bool, map(str.strip, lines))):
        return None
    return Teleplot(sum(":" in one["numbers"] for one in found) > LEAST_ALIKE * len(found))
