"""A table of any logger as one with the columns of a recording of the pen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from recordings.foreign.clocks import Clock
from recordings.foreign.groups import POSE, POSE_AXES, Group
from recordings.foreign.scales import Scale

UNIT_NORM = 0.1
"""How far the norm of a quaternion may be from one."""


def recording_of_clock(
    clock: Clock,
    origin_s: float,
    scales: Mapping[str, Scale],
    pen: PenConfig,
    passed: Mapping[str, str],
    name: str,
) -> Recording:
    """Return the readings of a table's rows.

    Parameters
    ----------
    origin_s : from where times count
    scales : sensor → what turns its readings into SI
    passed : column → that of a recording, of truth and arrivals

    Raises
    ------
    InputError
        See `recordings.formats.tables.recording_from_table`.
    """
    from recordings.formats.tables import recording_from_table  # it reads with this

    rows = clock.mended.rows
    columns: dict[str, object] = {"time_s": clock.mended.time_s + (clock.origin_s - origin_s)}
    units = {}
    for sensor, group in clock.groups.items():
        axes = pen.sensors[sensor].reading_axes
        if group.own:
            for axis, header in group.headers.items():
                columns[group.own[axis]] = clock.table.frame[header].to_numpy()[rows]
            if sensor in scales and scales[sensor].is_asked:
                units[sensor] = scales[sensor].unit.name
            continue
        given = [(axis, unit) for axis, unit in axes if axis in group.headers or group.kind == POSE]
        values = _poses(group, scales[sensor]) if group.kind == POSE else group.values(
            [axis for axis, _ in given]
        ) * scales[sensor].unit.factor  # fmt: skip
        for (axis, unit), column in zip(given, values[rows].T, strict=True):
            columns[f"{sensor}_{axis}_{unit}"] = column
    for header, own in passed.items():
        columns[own] = clock.table.frame[header].to_numpy()[rows]
    return recording_from_table(pd.DataFrame(columns), pen, name, units=units)


def merged(recordings: Sequence[Recording], name: str) -> Recording:
    """Merge recordings of different sensors on one clock; no reading moves.

    Raises
    ------
    InputError
        If two have no instant in common.
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


def _poses(group: Group, scale: Scale) -> Array:
    """Return positions, m, and rotation vectors (n, 6); NaN where a quaternion is none."""
    values = group.values(POSE_AXES)
    norms = np.linalg.norm(values[:, 3:], axis=1)
    good = np.abs(norms - 1) < UNIT_NORM
    found = np.full((len(values), 6), np.nan)
    found[good, :3] = values[good, :3] * scale.unit.factor
    found[good, 3:] = Rotation.from_quat(values[good, 3:]).as_rotvec()
    return found
