"""When the rows of tables were captured: on one clock, without a reading that moves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from models.errors import InputError
from models.shown_text import short
from recordings.asked import Asked
from recordings.foreign.group import POSE, Group
from recordings.foreign.header_units import Unit
from recordings.foreign.matching import Matched
from recordings.foreign.repairs import MendedTimes, mended_times
from recordings.foreign.source_table import SourceTable
from recordings.foreign.stamps import (
    LARGE_S,
    Stamps,
    candidates_for,
    stamps_of,
)
from recordings.foreign.time_units import check_time_unit
from recordings.foreign.told import Remarks
from recordings.foreign.units_asked import unit_asked
from recordings.formats.columns import TIME


@dataclass(frozen=True, eq=False)
class Clock:
    """The rows of a table that have times, by one column of stamps.

    Parameters
    ----------
    mended : which rows, and their times after `origin_s`
    groups : sensor of the pen → its columns
    origin_s : what is taken off the stamps, s, which would be too large to add anything to
    """

    table: SourceTable
    stamps: Stamps
    mended: MendedTimes
    groups: Mapping[str, Group]
    origin_s: float


def is_rate(key: str, names: Sequence[str]) -> bool:
    """Whether somebody says a rate in place of a column of times: ``time=100Hz``."""
    return key == TIME and names[0].casefold().endswith("hz")


def clocks_of(
    tables: Sequence[SourceTable],
    chosen: Matched,
    named: Sequence[Mapping[str, Sequence[str]]],
    *,
    asked: Asked,
    units: Mapping[str, str],
    told: Remarks,
) -> list[Clock]:
    """Return the rows that are read, a clock for each column of stamps.

    Parameters
    ----------
    named : for each table, sensor or ``time`` → columns that somebody names
    units : sensor or ``time`` → unit that somebody says

    Raises
    ------
    InputError
        If a table has no stamps, or no rows, or their unit cannot be what it says.
    """
    found: list[Clock] = []
    for table, columns in zip(tables, named, strict=True):
        where = f"recording {table.name}"
        by_header: dict[str, tuple[Stamps, dict[str, Group]]] = {}
        of_column: dict[tuple[str, ...], Stamps] = {}
        for sensor, group in chosen.sensors.items():
            if group.table is table:
                candidates = candidates_for(table, group.kind)
                if candidates not in of_column:
                    of_column[candidates] = stamps_asked(
                        table, asked, where,
                        named=columns.get(TIME), units=units, kind=group.kind,
                    )  # fmt: skip
                stamps = of_column[candidates]
                by_header.setdefault(stamps.header, (stamps, {}))[1][sensor] = group
        for stamps, groups in by_header.values():
            found.append(_clock(table, stamps, groups, where))
            told.repairs += [
                f"{table.name}: {one}" for one in (*stamps.repairs, *found[-1].mended.repairs)
            ]
            told.notes += [f"{table.name}: {one}" for one in (*stamps.said, *found[-1].mended.said)]
            if stamps.is_to_be_said:
                told.notes.append(
                    f"{table.name}: times from {stamps.header}, in {stamps.unit.name}"
                )
    return found


def origin_of(clocks: Sequence[Clock], told: Remarks) -> float:
    """Return from where times count, s: as they stand, but for those that begin very late.

    Raises
    ------
    InputError
        If some count from an epoch and others do not.
    """
    origins = {clock.origin_s > 0 for clock in clocks}
    if len(origins) > 1:
        names = " and ".join(f"{clock.table.name} {clock.stamps.header}" for clock in clocks)
        raise InputError(f"{names} are of different clocks, expected files of one recording")
    origin_s = min(clock.origin_s for clock in clocks)
    if origin_s > 0:
        told.notes.append(f"times count from {origin_s:.0f} s of the file's clock")
    return origin_s


def _clock(table: SourceTable, stamps: Stamps, groups: Mapping[str, Group], where: str) -> Clock:
    if not len(table.frame):
        raise InputError(f"{where} is empty below its header, expected at least one sample")
    origin_s = float(math.floor(stamps.first_s())) if stamps.first_s() > LARGE_S else 0.0
    mended = mended_times(
        stamps.seconds(origin_s),
        lambda: np.column_stack([group.values(tuple(group.headers)) for group in groups.values()]),
    )
    if not len(mended.time_s):
        raise InputError(f"{where}: column {stamps.header} holds no times, expected some")
    if stamps.given != "option" and any(group.kind != POSE for group in groups.values()):
        check_time_unit(stamps.header, stamps.unit, mended.time_s, where)
    return Clock(table, stamps, mended, groups, origin_s)


def stamps_asked(
    table: SourceTable,
    asked: Asked,
    where: str,
    *,
    named: Sequence[str] | None,
    units: Mapping[str, str],
    kind: str | None,
) -> Stamps:
    """Return the stamps of a table's rows as somebody says them, else as they are found.

    Parameters
    ----------
    named : the column that somebody names
    units : ``time`` → unit, where somebody says it
    kind : see `recordings.foreign.stamps.stamps_of`

    Raises
    ------
    InputError
        If there are none, or a rate or a unit makes no sense.
    """
    given = asked.columns.get(TIME, ())
    if given and is_rate(TIME, given):
        try:
            rate_hz = float(given[0].casefold().removesuffix("hz"))
            per_row = Unit(f"rows at {rate_hz:g} Hz", "s", 1 / rate_hz)
        except (ValueError, ZeroDivisionError):
            raise InputError(f"columns: time={given[0]}, expected a rate like 100Hz") from None
        return Stamps("its rows", np.arange(len(table.frame)), per_row, "option")
    unit = None
    if TIME in units:
        unit = unit_asked(units[TIME], "s", f"{where}: unit {short(units[TIME])} of time")
    header = None if named is None else named[0]
    return stamps_of(table, where, header=header, unit=unit, kind=kind)
