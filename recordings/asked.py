"""What somebody says of a recording's file beside its path: columns, units, and how strictly."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from models.errors import InputError
from models.shown_text import value_text

ColumnsAsked = str | Mapping[str, str | Sequence[str]]
"""``"accel=ax,ay,az;time=millis"``, the same as a table, or names of columns without a header."""


@dataclass(frozen=True)
class Asked:
    """What somebody says of a file.

    Parameters
    ----------
    units : sensor, or ``time`` → unit: ``mg``, ``g/16384`` for counts of which 16384 make one
    columns : sensor, or ``time`` → the names of its columns in the file, with a minus in front of
        one that reads the other way round
    header : names of all columns of a file that has none
    strict : refuse what would have to be repaired
    """

    units: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    header: tuple[str, ...] | None = None
    strict: bool = False

    @property
    def is_of_others(self) -> bool:
        """Whether it is said of a file with columns of somebody else's."""
        scaled = any(key == "time" or {"/", "*"} & set(unit) for key, unit in self.units.items())
        return bool(self.columns or self.header or scaled)

    @classmethod
    def of(
        cls,
        units: Mapping[str, str] | None = None,
        columns: ColumnsAsked | None = None,
        *,
        strict: bool = False,
    ) -> Asked:
        """Return what is asked as people say it.

        Raises
        ------
        InputError
            If the columns make no sense.
        """
        header, by_name = None, {}
        if isinstance(columns, str) and "=" not in columns:
            header = _names(columns, columns)
        elif columns is not None:
            by_name = column_map(columns)
        return cls(units or {}, by_name, header, strict)


def column_map(columns: ColumnsAsked) -> dict[str, tuple[str, ...]]:
    """Return sensor, or ``time`` → the names of its columns.

    Raises
    ------
    InputError
        If a text is not like ``accel=ax,ay,az;time=millis``, or a name comes twice.
    """
    if not isinstance(columns, str):
        return {key: _names(names, key) for key, names in columns.items()}
    found: dict[str, tuple[str, ...]] = {}
    for part in filter(str.strip, columns.split(";")):
        key, equals, names = part.partition("=")
        if not equals or not key.strip() or key.strip() in found:
            raise InputError(
                f"columns {value_text(columns)}, expected e.g. accel=ax,ay,az;time=millis"
            )
        found[key.strip()] = _names(names, columns)
    return found


def _names(names: str | Sequence[str], whole: str) -> tuple[str, ...]:
    parts = re.split(r",(?![^()\[\]]*[)\]])", names) if isinstance(names, str) else names
    found = tuple(str(name).strip() for name in parts)
    if not found or not all(found):
        raise InputError(f"columns {value_text(whole)}, expected names of columns with commas")
    return found
