"""Columns without names, by what they read: gravity, and how it turns.

Three columns beside each other whose norm is about gravity in one unit are an accelerometer. Three
others that turn gravity as a gyroscope does, `recordings.turn_factor`, are one. The first column
that goes on is that of times. Anything less is no proof, and is left to who knows the file.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from models.arrays import Array
from models.errors import InputError
from models.units import STANDARD_GRAVITY_M_S2
from recordings.foreign.column_names import ACCELEROMETER, GYROSCOPE, meaning, time_words
from recordings.foreign.found_units import acceleration_unit
from recordings.foreign.source_table import SourceTable
from recordings.foreign.stamped_cells import stamped_cells
from recordings.foreign.time_units import found_unit
from recordings.formats.columns import loose_numbers
from recordings.plausible_units import spread
from recordings.turn_factor import rough_turn

_LEAST_ROWS, _MOST_COLUMNS = 100, 16
_WITHIN = 1.2
"""How far from gravity the median of the norm may lie, either way, …"""
_SPREAD = 0.4
"""… and nine in ten of the norms from their median, as a part of it."""
_GOES_ON = 0.9
"""Part of its steps that are forward, of a column of times."""
_LEAST_CORRELATION = 0.5
"""Of how gravity turns with how it should: a gyroscope's are 0.55 and more on rough motions,
those of a magnetometer, angles and accelerations less than 0.4."""
_USUAL_HZ = 100.0
"""Rate of rows without times; another changes the factor alone."""


def named_by_data(table: SourceTable) -> SourceTable:
    """Return a table without a header with names for what its columns read; others as they are.

    Raises
    ------
    InputError
        If it has six columns of readings, and only an accelerometer shows among them.
    """
    headers = [str(header) for header in table.frame.columns][:_MOST_COLUMNS]
    is_named = any(meaning(header, table.name) is not None for header in headers)
    if table.has_header or is_named or len(table.frame) < _LEAST_ROWS:
        return table
    stamps = {header: _stamps(table.frame[header], header) for header in headers}
    times = {header: at for header, at in stamps.items() if at is not None and len(at)}
    time = next((h for h in times if time_words(h) is not None), next(iter(times), None))
    numbers = [h for h in headers if h != time and _varies(table.frame[h], stamps[h])]
    threes = [numbers[k : k + 3] for k in range(0, len(numbers) - 2, 3)]
    rows = spread(len(table.frame))
    read = {h: loose_numbers(table.frame[h].iloc[rows]) for three in threes for h in three}
    values = [np.column_stack([read[header] for header in three]) for three in threes]
    forces = [k for k, one in enumerate(values) if _is_force(one)]
    if len(forces) != 1:
        return table
    force = forces[0]
    time_s = (np.arange(len(table.frame)) / _USUAL_HZ if time is None else times[time])[rows]
    known = np.isfinite(time_s)
    rates = [
        k
        for k, one in enumerate(values)
        if k != force and _turns_gravity(time_s[known], values[force][known], one[known])
    ]
    if len(rates) != 1 and len(threes) == 2:
        accel, gyro = (",".join(threes[k]) for k in (force, 1 - force))
        of_time = f"time={time or '100Hz'}"
        raise InputError(
            f"recording {table.name}: no header; columns {accel} read gravity, and the motion does "
            f"not show whether {gyro} are a gyroscope, expected a header, or if they are, "
            f'--columns "{of_time};accel={accel};gyro={gyro}"'
        )
    found = {ACCELEROMETER: threes[force]} | ({GYROSCOPE: threes[rates[0]]} if rates else {})
    names = {header: f"{kind} {axis}" for kind, three in found.items()
             for header, axis in zip(three, "xyz", strict=True)}  # fmt: skip
    if time is not None and time_words(time) is None:
        names[time] = "time"
    taken = "; ".join(f"{', '.join(three)} for {kind} x, y, z" for kind, three in found.items())
    why = "their norm is gravity" + (", which turns as the others say" if rates else "")
    said = f"no header: columns {taken} ({why})"
    return replace(table, frame=table.frame.rename(columns=names), said=(*table.said, said))


def _stamps(cells: pd.Series, header: str) -> Array | None:
    """Return when rows were by a column of numbers or dates that goes on, s; None for others."""
    stamped, is_date = stamped_cells(cells)
    if stamped is None or float((np.diff(stamped) > 0).mean()) < _GOES_ON:
        return None
    unit = 1e-9 if is_date else found_unit(header, stamped, None).factor
    if not is_date and float((np.diff(stamped) == 1).mean()) >= _GOES_ON:
        return np.zeros(0)  # it numbers the rows
    return np.asarray((stamped - stamped[np.isfinite(stamped).argmax()]) * unit, dtype=float)


def _varies(cells: pd.Series, stamps: Array | None) -> bool:
    """Whether a column may be a reading: of numbers, none that goes on, nor the same throughout."""
    is_number = pd.api.types.is_numeric_dtype(cells)
    return is_number and stamps is None and cells.nunique() > 1


def _is_force(values: Array) -> bool:
    found = acceleration_unit(values)
    if found is None:
        return False
    norms = np.linalg.norm(values, axis=1)
    norms = norms[np.isfinite(norms)]
    median = float(np.median(norms))
    off = np.quantile(np.abs(norms / median - 1), 0.9)
    in_g = median * found.unit.factor / STANDARD_GRAVITY_M_S2
    return bool(off <= _SPREAD and 1 / _WITHIN <= in_g <= _WITHIN)


def _turns_gravity(time_s: Array, force: Array, rate: Array) -> bool:
    whole = np.isfinite(force).all(axis=1) & np.isfinite(rate).all(axis=1)
    found = rough_turn(time_s[whole], force[whole], time_s[whole], rate[whole])
    return found is not None and found.correlation >= _LEAST_CORRELATION
