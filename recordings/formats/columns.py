"""What the columns of a recording's table mean, and the numbers in them.

A header is a quantity and its unit: ``time_s``, ``<sensor>_<axis>_<unit>``,
``<sensor>_arrival_s`` or ``true_<state>``, each in any unit of its row of `models.units`; a
sensor's may lack the unit.

Messages count rows of data from 1: row 1 is the one below the header.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np
import pandas as pd

from models.arrays import Array
from models.errors import InputError
from models.names import did_you_mean
from models.pen_config import PenConfig
from models.shown_text import value_text
from models.true_path import TRUE_NAMES
from models.units import TIME_DIGITS, UNITS, accepted_names, accepted_units, with_unit

TIME, TRUTH_PREFIX, ARRIVAL = "time", "true_", "arrival"
_CACHED_ROWS = 8192


@dataclass(frozen=True)
class Column:
    """What a header means.

    Parameters
    ----------
    quantity : ``time``, ``accel_x``, ``true_tip_x_m``: the same in every unit
    unit : a key of a row of `models.units.UNITS`; empty for a true state
    factor : from the unit to SI
    """

    quantity: str
    unit: str
    factor: float


def recording_columns(pen: PenConfig, units: Mapping[str, str]) -> dict[str, Column]:
    """Return header → meaning, of every column that a recording of a pen may have.

    Parameters
    ----------
    units : sensor name → unit of its headers without one, SI where absent or
        a unit of something else (a camera's positions in mm, its angles in rad)
    """
    columns = {f"{TIME}_{unit}": Column(TIME, unit, f) for unit, f in UNITS["s"].items()}
    states = list(TRUE_NAMES)
    for sensor, config in pen.sensors.items():
        states += config.bias_states(sensor).names
        columns |= _sensor_columns(sensor, tuple(config.reading_axes), units.get(sensor, ""))
    for state in states:
        columns |= _state_columns(state)
    return columns


@lru_cache(maxsize=256)
def _sensor_columns(
    sensor: str, axes: tuple[tuple[str, str], ...], unit_given: str
) -> Mapping[str, Column]:
    columns = {}
    for axis, si_unit in axes:
        quantity, accepted = f"{sensor}_{axis}", accepted_units(si_unit)
        for unit, factor in accepted.items():
            columns[with_unit(quantity, unit)] = Column(quantity, unit, factor)
        unit = unit_given if unit_given in accepted else si_unit
        columns[quantity] = Column(quantity, unit, accepted[unit])
    arrival = f"{sensor}_{ARRIVAL}"
    columns |= {f"{arrival}_{unit}": Column(arrival, unit, f) for unit, f in UNITS["s"].items()}
    return MappingProxyType(columns)


@lru_cache(maxsize=256)
def _state_columns(state: str) -> Mapping[str, Column]:
    return MappingProxyType(
        {
            TRUTH_PREFIX + spelling: Column(TRUTH_PREFIX + state, "", factor)
            for spelling, factor in accepted_names(state).items()
        }
    )


def column_units(
    headers: Iterable[str], pen: PenConfig, *, units: Mapping[str, str] | None = None
) -> Mapping[str, str]:
    """Return sensor name → the unit that its columns are read in, where they share one.

    Parameters
    ----------
    headers : of a table that `recordings.formats.tables.recording_from_table` accepts
    units : sensor name → unit, for headers without one
    """
    columns = recording_columns(pen, units or {})
    unit_of = {columns[header].quantity: columns[header].unit for header in headers}
    shared = {}
    for sensor, config in pen.sensors.items():
        read = {unit_of.get(f"{sensor}_{axis}", "") for axis, _ in config.reading_axes}
        if len(read) == 1 and read != {""}:
            shared[sensor] = read.pop()
    return shared


def spellings(quantity: str, columns: Mapping[str, Column]) -> list[str]:
    """Return the headers that give a quantity, with units first."""
    return [header for header, column in columns.items() if column.quantity == quantity]


def expected_for(header: str, columns: Mapping[str, Column]) -> str:
    """Say what was expected in place of an unknown header: other units, or everything in SI."""
    if header.startswith(TRUTH_PREFIX):
        quantities = dict.fromkeys(column.quantity for column in columns.values())
        return f"one of {', '.join(q for q in quantities if q.startswith(TRUTH_PREFIX))}"
    stems = [c.quantity for c in columns.values() if header.startswith(c.quantity + "_")]
    if stems:
        return " or ".join(spellings(max(stems, key=len), columns))
    return ", ".join(
        spelling
        for spelling, column in columns.items()
        if column.factor == 1 and column.unit and spelling != column.quantity
    )


def check_units_given(
    units: Mapping[str, str], pen: PenConfig, headers: Iterable[str], where: str
) -> None:
    """Raise `InputError` for a unit of a sensor without such columns, or of something else."""
    for sensor, unit in units.items():
        axes = pen.sensors[sensor].reading_axes if sensor in pen.sensors else ()
        if not {f"{sensor}_{axis}" for axis, _ in axes} & set(headers):
            raise InputError(
                f"{where}: a unit is given for {sensor}, expected columns of it "
                "without a unit in their header"
            )
        accepted = [u for si in dict.fromkeys(u for _, u in axes) for u in accepted_units(si)]
        if unit not in accepted:
            raise InputError(
                f"{where}: unit {unit} of {sensor} is unknown, expected {' or '.join(accepted)}"
                f"{did_you_mean(unit, accepted)}"
            )


def numbers(cells: pd.Series, where: str, *, above: int = 0) -> Array:
    """Return a column's numbers (n,), NaN where a cell is empty; all else must be finite.

    Parameters
    ----------
    above : rows of the table in front of these

    Raises
    ------
    InputError
        If a cell holds anything else; the message names column and row.
    """
    if cells.dtype.kind in "mM":  # pandas would count a date's nanoseconds
        raise InputError(f"{where}: column {cells.name} holds {cells.dtype}, expected numbers")
    values = loose_numbers(cells)
    if np.isfinite(values).all():
        return values
    bad = np.flatnonzero(~np.isfinite(values) & cells.notna().to_numpy())
    if len(bad):
        found = value_text(str(cells.iloc[bad[0]]))
        raise InputError(
            f"{where}: column {cells.name}, row {above + bad[0] + 1}: {found} is not "
            "a finite number, expected one (a sensor without a reading has an empty cell)"
        )
    return values


def loose_numbers(cells: pd.Series) -> Array:
    """Return a column's numbers (n,), NaN or infinity where a cell holds anything else."""
    if isinstance(cells.dtype, np.dtype) and cells.dtype.kind in "fiu":
        return cells.to_numpy(dtype=float)
    try:
        return pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float, na_value=np.nan)
    except (TypeError, ValueError, OverflowError):  # objects, and whole numbers beyond a float
        return np.array([_number(cell) for cell in cells], dtype=float)


def _number(cell: object) -> float:
    """Return a cell's number; infinity where it has none."""
    try:
        return float(cell)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return np.inf


def side_by_side(columns: Sequence[Array], factors: Sequence[float] | Array | None = None) -> Array:
    """Return columns (n,), at least one, as (n, k): as they stand, or times factors (k,).

    Some rows at a time, so that all columns of a row are written while it is in the cache.
    """
    found = np.empty((len(columns[0]), len(columns)))
    for start in range(0, len(found), _CACHED_ROWS):
        rows = slice(start, start + _CACHED_ROWS)
        for k, column in enumerate(columns):
            np.multiply(column[rows], 1.0 if factors is None else factors[k], out=found[rows, k])
    return found


def increasing_times(
    time_s: Array, header: str, where: str, *, above: int = 0, before_s: float = -np.inf
) -> Array:
    """Return times (n,) to the nanosecond; none may be missing, repeated or go backward.

    Parameters
    ----------
    above : rows of the table in front of these
    before_s : time of the last of them

    Raises
    ------
    InputError
        If one is or does; the message names the row.
    """
    empty = np.flatnonzero(np.isnan(time_s))
    if len(empty):
        raise InputError(
            f"{where}: column {header} is empty in row {above + empty[0] + 1}, expected a time"
        )
    time_s = np.round(time_s, TIME_DIGITS)
    before = np.append(before_s, time_s[:-1])
    late = np.flatnonzero(time_s <= before)
    if len(late):
        row = late[0]
        raise InputError(
            f"{where}: column {header}: time of row {above + row + 1} ({time_s[row]:.12g} s) does "
            f"not follow the one before ({before[row]:.12g} s), expected increasing times"
        )
    return time_s
