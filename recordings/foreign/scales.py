"""The unit of a group of columns, and its factor to SI: asked for, written, or found."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.names import did_you_mean
from models.pen_config import PenConfig
from models.shown_text import short
from models.units import UNITS
from recordings.foreign.clocks import Clock
from recordings.foreign.found_units import acceleration_unit, field_unit, rate_unit
from recordings.foreign.group import POSE, TIP, Group
from recordings.foreign.header_units import KNOWN_UNITS, Unit
from recordings.foreign.loggers import Logger
from recordings.foreign.pairing import same_chip
from recordings.foreign.units_asked import unit_asked
from recordings.formats.columns import TIME
from recordings.plausible_units import spread

LARGEST_POSITION_M = 20.0
"""Positions beyond this, without a unit, are millimetres."""
LARGEST_WRITING_M = 1.0
"""A tip that moves over more than this, without a unit, does so in millimetres."""
_Readings = tuple[Array, Array]
_Force = tuple[Group, _Readings, str]


@dataclass(frozen=True)
class Scale:
    """What turns a group's readings into SI.

    Parameters
    ----------
    unit : its factor is that of the whole, a sign included
    why : what says so, for a sentence; empty where a header or an option says it
    is_asked : whether an option says it
    """

    unit: Unit
    why: str = ""
    is_asked: bool = False


def check_asked(units: Mapping[str, str], sensors: Iterable[str], name: str) -> None:
    """Raise `InputError` for a unit of a sensor that has no columns."""
    known = tuple(sensors)
    for sensor in units:
        if sensor != TIME and sensor not in known:
            raise InputError(
                f"recording {name}: a unit is given for {short(sensor)}, which has no columns, "
                f"expected one of {', '.join(known)}{did_you_mean(sensor, known)}"
            )


def scales_of(
    clocks: Sequence[Clock], units: Mapping[str, str], logger: Logger | None, pen: PenConfig
) -> dict[str, Scale]:
    """Return the scale of every sensor; accelerometers first, as they tell of gyroscopes.

    Raises
    ------
    InputError
        If a unit is none of its quantity or not the one that the header says, or nothing says that
        of an accelerometer.
    """
    scales: dict[str, Scale] = {}
    forces: list[_Force] = []
    every = [(clock, sensor, group) for clock in clocks for sensor, group in clock.groups.items()]
    for clock, sensor, group in sorted(every, key=lambda one: pen.sensors[one[1]].reads_rate):
        config = pen.sensors[sensor]
        si = config.reading_axes[0][1]
        asked = None
        if sensor in units:
            where = f"recording {group.table.name}: unit {short(units[sensor])} of {sensor}"
            asked = Scale(unit_asked(units[sensor], si, where), is_asked=True)
        written = None
        if group.unit is not None and group.unit.si == si:
            written = Scale(group.unit)
            if asked is not None and asked.unit != group.unit:
                raise InputError(
                    f"recording {group.table.name}: unit {short(units[sensor])} is given for "
                    f"{sensor}, and {group.columns()} say {group.unit.name}, "
                    "expected columns of it without a unit in their header"
                )
        axes = tuple(group.headers)
        rows = spread(len(clock.mended.time_s))
        kept = clock.mended.rows
        values = group.values(axes, rows if isinstance(kept, slice) else kept[rows])
        complete = np.isfinite(values).all(axis=1)
        read = clock.mended.time_s[rows][complete] + clock.origin_s, values[complete]
        if config.feels_gravity:
            scales[sensor] = _force_scale(group, read[1], asked or written, logger)
            if len(axes) == 3:
                forces.append((group, read, scales[sensor].unit.name))
        elif config.reads_rate:
            scales[sensor] = asked or written or _rate_scale(group, read, forces, logger)
        elif config.field_strength is not None:
            strength = config.field_strength
            scales[sensor] = asked or written or _field_scale(group, read[1], strength, logger)
        elif group.kind == POSE:
            far = np.abs(read[1][:, :3]).max(initial=0.0) > LARGEST_POSITION_M
            scales[sensor] = asked or written or _position_scale(bool(far))
        elif group.kind == TIP:
            wide = len(read[1]) > 0 and np.ptp(read[1], axis=0).max() > LARGEST_WRITING_M
            scales[sensor] = asked or written or _position_scale(bool(wide))
        else:
            unit = KNOWN_UNITS.get(si, Unit(si, si, 1.0))
            scales[sensor] = asked or written or Scale(unit, "assumed")
    return scales


def is_checked(scale: Scale) -> bool:
    """Whether a unit was given, and can be checked against the readings."""
    return not scale.why and scale.unit.name in UNITS.get(scale.unit.si, ())


def _force_scale(group: Group, values: Array, given: Scale | None, logger: Logger | None) -> Scale:
    sign = 1.0 if logger is None or group.own else logger.force_sign
    if given is not None:
        return _signed(given, sign)
    found = acceleration_unit(values) if values.shape[1] == 3 else None
    if found is not None:
        return _signed(Scale(found.unit, found.why), sign)
    if logger is not None and group.kind in logger.units:
        return _signed(
            Scale(KNOWN_UNITS[logger.units[group.kind]], f"as {logger.name} writes"), sign
        )
    norms = np.linalg.norm(values, axis=1)
    median = float(np.median(norms)) if len(norms) else 0.0
    raise InputError(
        f"recording {group.table.name}: the unit of {group.columns()} is not written, and the "
        f"median of its norm, {median:.4g}, is gravity in none, "
        f"expected --units {group.sensor}=m_s2, g, mg, or counts like g/16384"
    )


def _rate_scale(
    group: Group, read: _Readings, forces: Sequence[_Force], logger: Logger | None
) -> Scale:
    found = None
    if read[1].shape[1] == 3:
        beside = [force for force in forces if same_chip(force[0], group)] or forces
        _, of_force, force_unit = beside[0] if beside else (group, None, "")
        found = rate_unit(*read, of_force, force_unit=force_unit)
    is_sure = found is not None and found.why != "assumed"
    if not is_sure and logger is not None and group.kind in logger.units:
        return Scale(KNOWN_UNITS[logger.units[group.kind]], f"as {logger.name} writes")
    return Scale(KNOWN_UNITS["rad_s"], "assumed") if found is None else Scale(found.unit, found.why)


def _field_scale(group: Group, values: Array, strength_ut: float, logger: Logger | None) -> Scale:
    is_one = logger is not None and group.kind in logger.normalised
    found = field_unit(values, strength_ut, is_one=is_one) if values.shape[1] == 3 else None
    if found is not None:
        return Scale(found.unit, found.why)
    if logger is not None and group.kind in logger.units:
        return Scale(KNOWN_UNITS[logger.units[group.kind]], f"as {logger.name} writes")
    return Scale(KNOWN_UNITS["ut"], "assumed")


def _position_scale(is_large: bool) -> Scale:
    """Return metres, or millimetres for what is too large for them."""
    return Scale(KNOWN_UNITS["mm" if is_large else "m"], "assumed by how large they are")


def _signed(scale: Scale, sign: float) -> Scale:
    if sign > 0:
        return scale
    why = ", ".join(filter(None, (scale.why, "sign turned: it reads downward at rest")))
    return Scale(Unit(scale.unit.name, scale.unit.si, sign * scale.unit.factor), why)
