"""A truth's columns and units as somebody says them, as ``--columns`` says a recording's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from models.errors import InputError
from models.names import did_you_mean, unknown
from models.shown_text import short
from recordings.asked import Asked
from recordings.foreign.clocks import is_rate
from recordings.foreign.header_units import split_header
from recordings.foreign.named_columns import columns_asked
from recordings.foreign.source_table import SourceTable
from recordings.foreign.units_asked import unit_asked
from recordings.formats.columns import TIME
from recordings.truths.columns import ANGLE, DOWN, PLACE, TURN, TruthColumn
from recordings.truths.track import ANGLES


@dataclass(frozen=True)
class TruthQuantity:
    """What somebody may name the columns of.

    Parameters
    ----------
    kind, axes : of its columns, see `TruthColumn`
    fewest : of its columns, the first axes
    si : unit; empty where it has none
    """

    kind: str
    axes: tuple[int, ...]
    fewest: int = 1
    si: str = ""


QUANTITIES: Mapping[str, TruthQuantity] = MappingProxyType(
    {
        "position": TruthQuantity(PLACE, (0, 1, 2), 2, "m"),
        "quaternion": TruthQuantity(TURN, (0, 1, 2, 3), 4),
        **{
            name.removesuffix("_rad"): TruthQuantity(ANGLE, (axis,), si="rad")
            for axis, name in enumerate(ANGLES)
        },
        "down": TruthQuantity(DOWN, (0,)),
    }
)
"""Name → quantity; a quaternion's columns are x, y, z, w."""


def named_columns(
    tables: Sequence[SourceTable], asked: Asked, where: str
) -> list[dict[str, tuple[str, ...]]]:
    """Return, for each table, quantity, or ``time`` → those columns of it that are asked for.

    Raises
    ------
    InputError
        If no table has a column, a quantity is unknown, or has another number of columns.
    """
    for name, headers in asked.columns.items():
        quantity = QUANTITIES.get(name)
        if name != TIME and quantity is None:
            raise unknown(f"{where}: columns of", name, (TIME, *QUANTITIES))
        if quantity is not None and not quantity.fewest <= len(headers) <= len(quantity.axes):
            counts = sorted({quantity.fewest, len(quantity.axes)})
            raise InputError(
                f"{where}: {len(headers)} columns of {name}, "
                f"expected {' or '.join(map(str, counts))}"
            )
    columns = {key: names for key, names in asked.columns.items() if not is_rate(key, names)}
    return columns_asked(tables, columns, must_be=True, what="truth")


def meant_columns(
    named: Mapping[str, Sequence[str]], recognised: Mapping[str, TruthColumn]
) -> dict[str, TruthColumn]:
    """Return header → meaning: as somebody names them, the other kinds as they are recognised."""
    quantities = {name: QUANTITIES[name] for name in named if name != TIME}
    kinds = {quantity.kind for quantity in quantities.values()}
    found = {h: one for h, one in recognised.items() if one.kind not in kinds}
    for name, quantity in quantities.items():
        for axis, header in zip(quantity.axes, named[name], strict=False):
            plain = header.removeprefix("-")
            unit = split_header(plain)[1]
            factor = unit.factor if unit is not None and unit.si == quantity.si else None
            sign = -1.0 if header.startswith("-") else 1.0
            found[plain] = TruthColumn(quantity.kind, "", axis, factor, sign=sign)
    return found


def with_units(
    columns: Mapping[str, TruthColumn], units: Mapping[str, str], where: str
) -> dict[str, TruthColumn]:
    """Return columns in the units that somebody says.

    Raises
    ------
    InputError
        If a unit is none of its quantity, not the one that a header says, or of no column.
    """
    found = dict(columns)
    for name, text in units.items():
        if name == TIME:
            continue
        quantity = QUANTITIES.get(name)
        own = [
            header
            for header, one in columns.items()
            if quantity is not None and one.kind == quantity.kind and one.axis in quantity.axes
        ]
        if quantity is None or not quantity.si or not own:
            known = [key for key, one in QUANTITIES.items() if one.si]
            raise InputError(
                f"{where}: a unit is given for {short(name)}, which has no columns in one, "
                f"expected one of {', '.join((TIME, *known))}{did_you_mean(name, known)}"
            )
        unit = unit_asked(text, quantity.si, f"{where}: unit {short(text)} of {name}")
        for header in own:
            if found[header].factor not in (None, unit.factor):
                raise InputError(
                    f"{where}: unit {short(text)} is given for {name}, and {short(header)} says "
                    "another, expected columns of it without a unit in their header"
                )
            found[header] = replace(found[header], factor=unit.factor)
    return found
