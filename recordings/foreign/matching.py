"""Which group of columns is which sensor of the pen: by its name, else by its kind.

One accelerometer in the file is the pen's one accelerometer, whatever both are called. Of several
in a file the one with gravity in it counts, and what a logger has corrected counts less.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from models.pen_config import PenConfig
from models.units import STANDARD_GRAVITY_M_S2
from recordings.foreign.column_names import ACCELEROMETER, GRAVITY, LINEAR
from recordings.foreign.found_units import WITHIN, acceleration_unit
from recordings.foreign.group import Group
from recordings.foreign.header_units import words_of
from recordings.foreign.pairing import paired
from recordings.plausible_units import spread


@dataclass(frozen=True, eq=False)
class Matched:
    """What of a file is read.

    Parameters
    ----------
    sensors : of the pen → its columns
    without_gravity : those of them whose accelerometer has no gravity in it
    said : sentences on what was chosen from several
    """

    sensors: Mapping[str, Group]
    without_gravity: frozenset[str]
    said: tuple[str, ...]


def matched(groups: Sequence[Group], pen: PenConfig) -> Matched:
    """Match groups with the pen's sensors."""
    sensors = {group.sensor: group for group in groups if group.sensor is not None}
    said: list[str] = []
    open_groups = [group for group in groups if group.sensor is None]
    for kind in dict.fromkeys(config.kind for config in pen.sensors.values()):
        free = [n for n, config in pen.sensors.items() if config.kind == kind and n not in sensors]
        candidates = _candidates(open_groups, kind)
        if not free or not candidates:
            continue
        taken = paired(free, candidates, sensors)
        if len(candidates) > len(taken):
            left = [g for g in candidates if g not in taken.values()]
            said.append(
                f"{len(candidates)} {kind}s in the file: {', '.join(g.columns() for g in left)} "
                f"not used (--columns {free[0]}=… takes others)"
            )
        sensors |= {name: replace(group, sensor=name) for name, group in taken.items()}
    in_order = {name: sensors[name] for name in pen.sensors if name in sensors}
    lacking = frozenset(n for n, g in in_order.items() if g.kind == LINEAR and not _feels(g))
    return Matched(in_order, lacking, tuple(said))


def _candidates(groups: Sequence[Group], kind: str) -> list[Group]:
    """Return the groups of a kind that are as good as the best of them."""
    wanted = (ACCELEROMETER, LINEAR) if kind == ACCELEROMETER else (kind,)
    found = [g for g in groups if g.kind in wanted and _has_reading(g)]
    if kind == ACCELEROMETER:
        feel = [_feels(group) for group in found]
        sums = _sums([g for g, feels in zip(found, feel, strict=True) if not feels], groups)
        found, feel = found + sums, feel + [_feels(group) for group in sums]
        by_name = [g.kind == LINEAR and g.added is None for g in found]
        found = [replace(g, kind=ACCELEROMETER if feels else LINEAR)
                 for g, feels in zip(found, feel, strict=True)]  # fmt: skip
    else:
        by_name = [False] * len(found)
    ranks = [(_rank(group), linear) for group, linear in zip(found, by_name, strict=True)]
    return [group for group, rank in zip(found, ranks, strict=True) if rank == min(ranks)]


def _sums(lacking: Sequence[Group], groups: Sequence[Group]) -> list[Group]:
    """Return accelerations without gravity with the gravity that stands beside them added."""
    gravities = [g for g in groups if g.kind == GRAVITY and _has_reading(g)]
    return [
        replace(one, added=gravity.headers)
        for one in lacking
        for gravity in gravities
        if gravity.table is one.table and gravity.unit == one.unit
    ]


def _rank(group: Group) -> tuple[bool, bool, bool]:
    words = words_of(f"{group.label} {group.table.name}")
    return (
        group.kind == LINEAR,
        group.added is not None,
        any(word.startswith("uncal") for word in words),
    )


def _has_reading(group: Group) -> bool:
    frame = group.table.frame
    rows = spread(len(frame))
    columns = [frame[header] for header in group.headers.values()]
    if all(isinstance(c.dtype, np.dtype) and c.dtype.kind in "fiu" for c in columns):
        cells = (column.to_numpy()[rows] for column in columns)
        return any(bool(((one != 0) & ~np.isnan(one)).any()) for one in cells)
    values = frame[list(group.headers.values())].iloc[rows]
    return bool(values.notna().any(axis=None)) and not bool((values.fillna(0) == 0).all(axis=None))


def _feels(group: Group) -> bool:
    """Whether the median of |f| is near gravity in the unit of a group, or in any."""
    if len(group.headers) < 3:
        return True
    values = group.values("xyz", spread(len(group.table.frame)))
    found = acceleration_unit(values)
    if found is None or group.unit is None or math.isnan(group.unit.factor):
        return found is not None
    norms = np.linalg.norm(values, axis=1) * group.unit.factor
    median = float(np.nanmedian(norms))
    return abs(math.log(median / STANDARD_GRAVITY_M_S2)) <= math.log(WITHIN)
