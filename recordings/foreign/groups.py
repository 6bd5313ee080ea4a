"""Columns that are one sensor's reading: those of a kind and a label, one for each axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from models.errors import InputError
from models.names import unknown
from models.pen_config import PenConfig
from models.plain_names import plain_name
from recordings.foreign.column_names import (
    ATTITUDE,
    POSITION,
    kind_of_words,
    meaning,
    unit_of_kind,
)
from recordings.foreign.group import MINUS, POSE, POSE_AXES, TIP, Group
from recordings.foreign.header_units import KNOWN_UNITS, Unit, split_header
from recordings.foreign.source_table import SourceTable
from recordings.formats.columns import ARRIVAL, TIME, TRUTH_PREFIX, Column


def canonical_headers(table: SourceTable, known: Mapping[str, Column]) -> dict[str, str]:
    """Return the table's columns that a recording of the pen has by the same name, → that name.

    Capital letters, dashes and blanks do not count.
    """
    by_plain = {name.casefold(): name for name in known}
    found = {}
    for header in map(str, table.frame.columns):
        name = by_plain.get(plain_name(header).casefold())
        if name is not None and name != TIME:
            found[header] = name
    return found


def groups_of(
    table: SourceTable,
    pen: PenConfig,
    canonical: Mapping[str, str],
    known: Mapping[str, Column],
    asked: Mapping[str, Sequence[str]],
) -> list[Group]:
    """Return the groups of a table: those that somebody names, then the pen's own, then by words.

    Parameters
    ----------
    canonical : of `canonical_headers`
    known : header → meaning, of `recordings.formats.columns.recording_columns`
    asked : sensor → columns of this table

    Raises
    ------
    InputError
        If a sensor is asked for with another number of columns than it has axes.
    """
    groups = [_asked(table, pen, sensor, names) for sensor, names in asked.items()]
    taken = {header for group in groups for header in group.headers.values()}
    named = {group.sensor for group in groups}
    for sensor, config in pen.sensors.items():
        own = {
            axis: (header, name)
            for axis, _ in config.reading_axes
            for header, name in canonical.items()
            if known[name].quantity == f"{sensor}_{axis}"
        }
        if own and sensor not in named:
            headers = {axis: header for axis, (header, _) in own.items()}
            names = {axis: name for axis, (_, name) in own.items()}
            groups.append(_own(config.kind, table, headers, names, known, sensor))
            taken |= set(headers.values())
    found: dict[tuple[str, str], tuple[dict[str, str], list[Unit | None]]] = {}
    numbered = numbered_axes(list(map(str, table.frame.columns)))
    for header in map(str, table.frame.columns):
        is_open = header not in taken and header not in canonical
        told = meaning(numbered.get(header, header), table.name) if is_open else None
        if told is not None:
            axes, written = found.setdefault((told.kind, told.label), ({}, []))
            axes.setdefault(told.axis, header)
            written.append(told.unit)
    for (kind, label), (headers, written) in found.items():
        if set("xyz") <= set(headers) or (len(headers) < 3 and kind != ATTITUDE):
            unit = written[0] if len(set(written)) == 1 else None
            ordered = {axis: headers[axis] for axis in "xyzw" if axis in headers}
            groups.append(Group(kind, label, table, ordered, unit))
    return groups


def numbered_axes(headers: Sequence[str]) -> dict[str, str]:
    """Return header → the same with a letter, of columns numbered from 0 or 1 on:
    ``Acceleration_1`` to ``Acceleration_3``, ``Accel Channel 0`` to ``Accel Channel 2``.
    """
    found: dict[str, str] = {}
    for header in headers:
        stem, first = header[:-1], header[-1:]
        if first in ("0", "1") and meaning(header) is None and header not in found:
            three = {f"{stem}{int(first) + k}": f"{stem}_{axis}" for k, axis in enumerate("xyz")}
            around = {f"{stem}{int(first) + k}" for k in (-1, len(three))}
            if set(three) <= set(headers) and not around & set(headers):
                found |= three
    return found


def _own(
    kind: str,
    table: SourceTable,
    headers: Mapping[str, str],
    names: Mapping[str, str],
    known: Mapping[str, Column],
    sensor: str,
) -> Group:
    """Return the group of columns that are called as a recording of the pen calls them."""
    if all(known[name].quantity == name for name in names.values()):
        return Group(kind, "", table, headers, None, sensor, known=known)  # no unit is written
    units = {KNOWN_UNITS.get(known[name].unit) for name in names.values()}
    unit = units.pop() if len(units) == 1 else None
    return Group(kind, "", table, headers, unit, sensor, own=names, known=known)


def with_poses(groups: Sequence[Group]) -> list[Group]:
    """Join positions and quaternions of one label to poses; a position alone is a tip's."""
    joined = [group for group in groups if group.kind not in (POSITION, ATTITUDE)]
    for place in (group for group in groups if group.kind == POSITION):
        poses = [
            {**place.headers, **{f"q{axis}": header for axis, header in turn.headers.items()}}
            for turn in groups
            if turn.kind == ATTITUDE and turn.table is place.table and turn.label == place.label
            if "w" in turn.headers and len(place.headers) == 3
        ]
        joined += [replace(place, kind=POSE, headers=headers) for headers in poses]
        joined += [] if poses else [replace(place, kind=TIP)]
    return joined


def is_passed_on(quantity: str) -> bool:
    """Whether a recording takes a column beside those of its sensors: truth, and arrivals."""
    return quantity.startswith(TRUTH_PREFIX) or quantity.endswith(f"_{ARRIVAL}")


def _asked(table: SourceTable, pen: PenConfig, name: str, names: Sequence[str]) -> Group:
    config = pen.sensors.get(name)
    kind = kind_of_words(name) if config is None else config.kind
    if kind is None:
        raise unknown("columns: sensor", name, ("time", *pen.sensors))
    axes = tuple("xyz") if config is None else tuple(axis for axis, _ in config.reading_axes)
    if config is not None and config.sees_pose and len(names) == len(POSE_AXES):
        kind, axes = POSE, _pose_axes(names)
    if len(names) != len(axes):
        raise InputError(
            f"columns of {name}: {', '.join(names)}, "
            f"expected {len(axes)} of them: {', '.join(axes)}"
        )
    own = set(map(str, table.frame.columns))
    signs = {
        axis: -1.0
        for axis, header in zip(axes, names, strict=True)
        if header not in own and header.startswith(MINUS)
    }
    headers = {
        axis: header.removeprefix(MINUS) if axis in signs else header
        for axis, header in zip(axes, names, strict=True)
    }
    units = {split_header(header)[1] for header in headers.values()}
    unit = unit_of_kind(kind, units.pop()) if len(units) == 1 else None
    sensor = None if config is None else name
    return Group(kind, "", table, headers, unit, sensor, signs=signs)


def _pose_axes(names: Sequence[str]) -> tuple[str, ...]:
    """Return which column is which: as their names say, else w last."""
    told = [meaning(name) for name in names[3:]]
    axes = tuple(f"q{one.axis}" for one in told if one is not None)
    return (*POSE_AXES[:3], *(axes if sorted(axes) == sorted(POSE_AXES[3:]) else POSE_AXES[3:]))
