"""The readings of a table's rows, in SI, as a recording of the pen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from estimation.recording import Recording, Truth
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from models.shown_text import short
from models.units import TIME_DIGITS
from recordings.foreign.clocks import Clock
from recordings.foreign.group import POSE_AXES, Group
from recordings.foreign.scales import Scale
from recordings.foreign.told import Remarks
from recordings.formats.columns import ARRIVAL, TRUTH_PREFIX, Column, expected_for, numbers

UNIT_NORM = 0.1
"""How far the norm of a quaternion may be from one."""


def recording_of_clock(
    clock: Clock,
    origin_s: float,
    scales: Mapping[str, Scale],
    *,
    pen: PenConfig,
    passed: Mapping[str, Column],
    name: str,
    told: Remarks,
) -> Recording:
    """Return the readings of a table's rows.

    Parameters
    ----------
    origin_s : from where times count
    scales : sensor → what turns its readings into SI
    passed : column → what it means, of truth and arrivals

    Raises
    ------
    InputError
        If an axis of a sensor is missing or has no readings, or a cell is not a finite number.
    """
    where, rows = f"recording {name}", clock.mended.rows
    readings: dict[str, Array] = {}
    for sensor, group in clock.groups.items():
        config = pen.sensors[sensor]
        axes = [axis for axis, _ in config.reading_axes]
        if group.has_quaternion:
            values = _poses(group.values(POSE_AXES, rows), scales[sensor])
        else:
            _check_axes(group, sensor, axes, where)
            factors = group.factors(axes, scales[sensor].unit.factor)
            values = group.values(axes, rows, factors=factors)
        if len(values) and not np.isnan(values.min()):  # then none is missing
            readings[sensor] = values
            continue
        gaps = np.isnan(values)
        missing = gaps.any(axis=1)
        if not gaps.all(axis=0).any():
            readings[sensor] = values
            if missing.any():
                of_all = f"{int(missing.sum())} of {len(values)} rows"
                told.notes.append(f"{sensor}: {of_all} without a whole reading")
        elif config.may_be_silent:
            told.notes.append(f"{sensor} has no reading, left out")
        else:
            raise InputError(
                f"{where}: the columns of {sensor} are empty, expected a reading or no such columns"
            )
    time_s = np.round(clock.mended.time_s + (clock.origin_s - origin_s), TIME_DIGITS)
    frame = clock.table.frame
    more = {
        column.quantity: numbers(frame[header], where)[rows] * column.factor
        for header, column in passed.items()
    }
    states = {
        k.removeprefix(TRUTH_PREFIX): v for k, v in more.items() if k.startswith(TRUTH_PREFIX)
    }
    truth = None
    if states:
        truth = Truth(time_s, tuple(states), np.column_stack(list(states.values())))
    arrivals = {
        sensor: np.round(more[f"{sensor}_{ARRIVAL}"], TIME_DIGITS)
        for sensor in readings
        if f"{sensor}_{ARRIVAL}" in more
    }
    return Recording(name, time_s, readings, truth, arrivals=arrivals)


def merged(recordings: Sequence[Recording], name: str) -> Recording:
    """Merge recordings of different sensors on one clock; no reading moves.

    Raises
    ------
    InputError
        If one has no instant in common with any other.
    """
    if len(recordings) == 1:
        return recordings[0]
    for one in recordings:
        others = [other for other in recordings if other is not one]
        if all(one.time_s[-1] < o.time_s[0] or o.time_s[-1] < one.time_s[0] for o in others):
            raise InputError(
                f"recording {name}: {' and '.join(one.readings)} was read from "
                f"{one.time_s[0]:.6g} to {one.time_s[-1]:.6g} s, when nothing else was, "
                "expected files of one recording on one clock"
            )
    sensors = {key: one.sensor(key) for one in recordings for key in one.readings}
    arrivals = {
        key: at[np.isin(one.time_s, sensors[key][0])]
        for one in recordings
        for key, at in one.arrivals.items()
    }
    truth = next((one.truth for one in recordings if one.truth is not None), None)
    return Recording.from_sensors(name, sensors, truth=truth, arrivals=arrivals)


def _check_axes(group: Group, sensor: str, axes: Sequence[str], where: str) -> None:
    missing = [f"{sensor}_{axis}" for axis in axes if axis not in group.headers]
    if not missing:
        return
    headers = [str(header) for header in group.table.frame.columns]
    other = next((header for header in headers if header.startswith(f"{missing[0]}_")), None)
    if other is not None:
        raise InputError(
            f"{where}: unknown column {short(other)}, expected {expected_for(other, group.known)}"
        )
    raise InputError(
        f"{where}: column {', '.join(missing)} is missing, expected every axis of {sensor}"
    )


def _poses(values: Array, scale: Scale) -> Array:
    """Return positions, m, and rotation vectors (n, 6); NaN where a quaternion is none."""
    norms = np.linalg.norm(values[:, 3:], axis=1)
    good = np.abs(norms - 1) < UNIT_NORM
    found = np.full((len(values), 6), np.nan)
    found[good, :3] = values[good, :3] * scale.unit.factor
    found[good, 3:] = Rotation.from_quat(values[good, 3:]).as_rotvec()
    return found
