"""A recording from tables of any logger: whose columns, in which units, at which times.

Every table becomes one with the columns of `recordings.formats.columns`, and is read as such.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import attrgetter

import pandas as pd

from models.errors import InputError
from models.pen_config import PenConfig
from models.shown_text import one_line, short
from recordings.asked import Asked
from recordings.finding import Finding, Severity
from recordings.foreign.clocks import Clock, clocks_of, is_rate, origin_of
from recordings.foreign.group import Group
from recordings.foreign.groups import (
    canonical_headers,
    groups_of,
    is_passed_on,
    with_poses,
)
from recordings.foreign.loggers import logger_of
from recordings.foreign.long_tables import unstacked
from recordings.foreign.matching import Matched, matched
from recordings.foreign.named_columns import check_canonical, columns_asked
from recordings.foreign.nameless import named_by_data
from recordings.foreign.placeholders import without_placeholders
from recordings.foreign.readings import merged, recording_of_clock
from recordings.foreign.scales import Scale, check_asked, is_checked, scales_of
from recordings.foreign.source_table import SourceTable
from recordings.foreign.told import Remarks
from recordings.formats.columns import TIME, Column, recording_columns
from recordings.plausible_units import check_units
from recordings.written import WrittenRecording

MOST_NAMED = 12
"""Columns that are named in a sentence; of more it is said how many."""


def recording_of_tables(
    tables: Sequence[SourceTable], pen: PenConfig, asked: Asked, name: str
) -> WrittenRecording:
    """Read tables of one recording.

    Raises
    ------
    InputError
        If no sensor of the pen is recognised, a unit cannot be what it says, there are no times,
        or something had to be repaired that `asked` is too strict for.
    """
    told = Remarks()
    tables = [part for table in tables for part in unstacked(table)]
    if asked.header is None and not asked.columns.keys() - {TIME}:
        tables = [named_by_data(table) for table in tables]
    tables = [without_placeholders(table) for table in tables]
    for table in tables:
        told.notes += [f"{table.name}: {sentence}" for sentence in table.said]
        told.repairs += [f"{table.name}: {sentence}" for sentence in table.repairs]
    logger = logger_of(tables)
    if logger is not None:
        told.notes.append(f"columns as {logger.name} writes them")
    known = recording_columns(pen, {})
    canonical = [canonical_headers(table, known) for table in tables]
    named = _columns_named(tables, pen, asked)
    if not asked.columns:
        for table, own in zip(tables, canonical, strict=True):
            check_canonical(table, own, known, f"recording {name}")
    chosen = _match(tables, pen, canonical, known, named, name)
    told.notes += chosen.said
    units = {**({} if pen.recording is None else pen.recording.units), **asked.units}
    check_asked(asked.units, chosen.sensors, name)
    clocks = clocks_of(tables, chosen, named, asked=asked, units=units, told=told)
    passed = [
        {h: known[n] for h, n in own.items() if is_passed_on(known[n].quantity)}
        for own in canonical
    ]
    origin_s = 0.0 if any(passed) else origin_of(clocks, told)
    scales = scales_of(clocks, units, logger, pen)
    recordings = [
        recording_of_clock(
            clock,
            origin_s,
            scales,
            pen=pen,
            passed=passed[tables.index(clock.table)],
            name=name,
            told=told,
        )
        for clock in clocks
    ]
    _say_sensors(clocks, scales, chosen, told)
    left = _say_unused(tables, clocks, passed, told)
    _say_missing(left, chosen, pen, told)
    if asked.strict and told.repairs:
        raise InputError(
            f"recording {name}: {told.repairs[0]}, expected a file that needs no repair (--strict)"
        )
    recording = merged(recordings, name)
    read_as = {
        sensor: scale.unit.name
        for sensor, scale in scales.items()
        if is_checked(scale) and sensor not in chosen.without_gravity
    }
    if read_as:
        check_units(recording, pen, read_as=read_as)
    notes = [*told.notes, *(f"repaired: {sentence}" for sentence in told.repairs)]
    return WrittenRecording(
        recording,
        notes=tuple(map(one_line, notes)),
        findings=tuple(told.findings),
        origin_s=origin_s,
        columns={
            sensor: tuple(map(one_line, group.axis_columns()))
            for sensor, group in chosen.sensors.items()
        },
    )


def _columns_named(
    tables: Sequence[SourceTable], pen: PenConfig, asked: Asked
) -> list[dict[str, tuple[str, ...]]]:
    """Return, for each table, what the pen file names in it, and over it what is asked for."""
    columns = {key: names for key, names in asked.columns.items() if not is_rate(key, names)}
    ours = columns_asked(tables, columns, must_be=True)
    of_pen = {} if pen.recording is None else pen.recording.columns
    theirs = columns_asked(tables, of_pen, must_be=False)
    return [
        {**{key: names for key, names in theirs_of.items() if key not in asked.columns}, **ours_of}
        for theirs_of, ours_of in zip(theirs, ours, strict=True)
    ]


def _match(
    tables: Sequence[SourceTable],
    pen: PenConfig,
    canonical: Sequence[Mapping[str, str]],
    known: Mapping[str, Column],
    named: Sequence[Mapping[str, Sequence[str]]],
    name: str,
) -> Matched:
    groups: list[Group] = []
    for table, own, columns in zip(tables, canonical, named, strict=True):
        sensors = {key: names for key, names in columns.items() if key != TIME}
        groups += groups_of(table, pen, own, known, sensors)
    chosen = matched(with_poses(groups), pen)
    if not chosen.sensors:
        headers = [str(header) for table in tables for header in table.frame.columns]
        numbered = not any(table.has_header for table in tables)
        meant = (
            'a header, or --columns "time=1;accel=2,3,4;gyro=5,6,7" for columns by their numbers'
            if numbered
            else 'names like accel_x_m_s2 or ax, ay, az, or --columns "accel=…,…,…;time=…"'
        )
        raise InputError(
            f"recording {name}: no sensor's columns among {_some(headers)}, expected {meant}"
        )
    return chosen


def _say_sensors(
    clocks: Sequence[Clock], scales: Mapping[str, Scale], chosen: Matched, told: Remarks
) -> None:
    for clock in clocks:
        for sensor, group in clock.groups.items():
            scale = scales.get(sensor)
            if not group.own and scale is not None:
                why = f" ({scale.why})" if scale.why else ""
                told.notes.append(f"{sensor} from {group.columns()} in {scale.unit.name}{why}")
            elif not group.own:
                told.notes.append(f"{sensor} from {group.columns()}")
            if sensor in chosen.without_gravity:
                told.findings.append(
                    Finding(
                        "there is no gravity in it (user or linear acceleration)",
                        f"{sensor} ({group.columns()})",
                        1.0,
                        "record the accelerometer itself, or the gravity beside it",
                        Severity.NOT_MEANT,
                        check="missing gravity",
                    )
                )


def _say_unused(
    tables: Sequence[SourceTable],
    clocks: Sequence[Clock],
    passed: Sequence[Mapping[str, Column]],
    told: Remarks,
) -> list[str]:
    """Say which columns are not read; return those of numbers beside some that are."""
    of_numbers: list[str] = []
    for table, own in zip(tables, passed, strict=True):
        here = [clock for clock in clocks if clock.table is table]
        used = {header for clock in here for g in clock.groups.values() for header in g.used()}
        used |= {header for clock in here for header in clock.stamps.headers}
        left = [h for h in map(str, table.frame.columns) if h not in used and h not in own]
        if not here:
            told.notes.append(f"{table.name}: nothing of it is needed, ignored")
        elif left:
            told.notes.append(f"{table.name}: not needed, ignored: {_some(left)}")
            of_numbers += [h for h in left if pd.api.types.is_numeric_dtype(table.frame[h])]
    return of_numbers


def _say_missing(left: Sequence[str], chosen: Matched, pen: PenConfig, told: Remarks) -> None:
    """Say where an accelerometer or a gyroscope of the pen may be among columns left out."""
    for is_one in (attrgetter("feels_gravity"), attrgetter("reads_rate")):
        names = [name for name, sensor in pen.sensors.items() if is_one(sensor)]
        if names and len(left) >= len("xyz") and not set(names) & set(chosen.sensors):
            told.notes.append(
                f"no {pen.sensors[names[0]].kind} was recognised: if three of {_some(left)} are "
                f"one, --columns {names[0]}=…,…,… takes them"
            )


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return ", ".join(map(short, names[:MOST_NAMED])) + more
