"""The header of a recording's table: which column gives what, and the rows below it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from estimation.recording import Recording, Truth
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from models.plain_names import plain_headers
from models.shown_text import short, value_text
from models.units import TIME_DIGITS
from recordings.formats.columns import (
    ARRIVAL,
    TIME,
    TRUTH_PREFIX,
    Column,
    check_units_given,
    column_units,
    expected_for,
    increasing_times,
    numbers,
    recording_columns,
    side_by_side,
    spellings,
)


@dataclass(frozen=True)
class TableHeader:
    """What the columns of a table give of a pen's recording.

    Parameters
    ----------
    where : ``recording run 3.csv``, for messages
    name : of the recording
    headers : in order of the columns, as they are read
    columns : header → meaning
    sensors : sensor → its quantities, in the order of its axes; none that is left out
    units : sensor → the unit that its columns are read in, where they share one
    silent : sensors that are left out, for their columns have no reading
    """

    where: str
    name: str
    headers: tuple[str, ...]
    columns: Mapping[str, Column]
    sensors: Mapping[str, tuple[str, ...]]
    units: Mapping[str, str]
    silent: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        headers: Sequence[str],
        pen: PenConfig,
        name: str,
        *,
        units: Mapping[str, str] | None = None,
    ) -> TableHeader:
        """Understand a header, or raise `InputError` for the column that is wrong.

        Parameters
        ----------
        units : sensor name → unit of its columns, for headers without one
        """
        where, units = f"recording {name}", units or {}
        known = recording_columns(pen, units)
        headers = plain_headers([str(header) for header in headers], known, where)
        found: dict[str, str] = {}
        for header in headers:
            if header not in known:
                raise InputError(
                    f"{where}: unknown column {short(header)}, "
                    f"expected {expected_for(header, known)}"
                )
            quantity = known[header].quantity
            other = found.setdefault(quantity, header)
            if other != header:
                raise InputError(
                    f"{where}: columns {other} and {header} both give {quantity}, expected one"
                )
        check_units_given(units, pen, headers, where)
        if TIME not in found:
            raise InputError(
                f"{where}: expected exactly one column of {', '.join(spellings(TIME, known))}, "
                "found none"
            )
        sensors = _sensors(found, pen, where)
        if not sensors:
            raise InputError(f"{where}: no sensor's columns, expected {expected_for('', known)}")
        columns = {header: known[header] for header in headers}
        shared = column_units(headers, pen, units=units)
        return cls(where, name, tuple(headers), columns, sensors, shared)

    @property
    def truth_names(self) -> tuple[str, ...]:
        """The true states that there are columns of."""
        quantities = (self.columns[header].quantity for header in self.headers)
        return tuple(q.removeprefix(TRUTH_PREFIX) for q in quantities if q.startswith(TRUTH_PREFIX))

    @property
    def stamps(self) -> tuple[str, str]:
        """The header of the times, and their unit."""
        return next((h, c.unit) for h, c in self.columns.items() if c.quantity == TIME)

    def without_silent(
        self, pen: PenConfig, tables: Iterable[pd.DataFrame]
    ) -> tuple[TableHeader, tuple[str, ...]]:
        """Leave out sensors that may be silent and were: a contact, while the tip touched nothing.

        Parameters
        ----------
        tables : rows of the columns that this is the header of, all of them in turn; taken until
            every such sensor has had a reading

        Returns
        -------
        The header without these, and a sentence on each
        """
        silent = {
            sensor: [i for i, h in enumerate(self.headers) if self.columns[h].quantity in axes]
            for sensor, axes in self.sensors.items()
            if pen.sensors[sensor].may_be_silent
        }
        for table in tables if silent else ():
            for sensor, columns in list(silent.items()):
                if table.iloc[:, columns].notna().any(axis=None):
                    del silent[sensor]
            if not silent:
                break
        sensors = {name: axes for name, axes in self.sensors.items() if name not in silent}
        if not sensors:  # then its columns are empty, which is refused
            return self, ()
        notes = tuple(f"{sensor} has no reading, left out" for sensor in silent)
        return replace(self, sensors=sensors, silent=tuple(silent)), notes

    def recording(
        self, table: pd.DataFrame, *, above: int = 0, before_s: float = -np.inf
    ) -> Recording:
        """Return the recording of some rows, at least one; empty columns are not refused.

        Parameters
        ----------
        table : rows of the columns that this is the header of
        above : rows in front of these
        before_s : time of the last of them

        Raises
        ------
        InputError
            If a cell is not a finite number, or times do not increase; the message names column
            and row.
        """
        table = table.set_axis(list(self.headers), axis=1)
        values = {
            column.quantity: self._in_si(table[header], column.factor, above)
            for header, column in self.columns.items()
        }
        header, _ = self.stamps
        time_s = increasing_times(values[TIME], header, self.where, above=above, before_s=before_s)
        readings = {
            sensor: side_by_side([values[axis] for axis in axes])
            for sensor, axes in self.sensors.items()
        }
        arrivals = {
            sensor: np.round(given, TIME_DIGITS)
            for quantity, given in values.items()
            if quantity.endswith(f"_{ARRIVAL}")
            and (sensor := quantity.removesuffix(f"_{ARRIVAL}")) not in self.silent
        }
        truth, names = None, self.truth_names
        if names:
            states = np.column_stack([values[TRUTH_PREFIX + name] for name in names])
            truth = Truth(time_s, names, states)
        return Recording(self.name, time_s, readings, truth, arrivals=arrivals)

    def _in_si(self, cells: pd.Series, factor: float, above: int) -> Array:
        values = numbers(cells, self.where, above=above)
        if factor == 1:
            return values
        with np.errstate(over="ignore"):
            values = values * factor
        beyond = np.flatnonzero(np.isinf(values))
        if len(beyond):
            row = beyond[0]
            raise InputError(
                f"{self.where}: column {cells.name}, row {above + row + 1}: "
                f"{value_text(str(cells.iloc[row]))} is beyond the largest number in SI, "
                "expected a smaller one"
            )
        return values

    def empty(self, sensor: str) -> InputError:
        """Return the refusal of a sensor's columns without any number."""
        return InputError(
            f"{self.where}: the columns of {sensor} are empty, "
            "expected a reading or no such columns"
        )


def _sensors(found: Mapping[str, str], pen: PenConfig, where: str) -> dict[str, tuple[str, ...]]:
    """Return sensor → its quantities, of sensors that have columns; `InputError` for a part."""
    sensors = {}
    for sensor, config in pen.sensors.items():
        axes = tuple(f"{sensor}_{axis}" for axis, _ in config.reading_axes)
        missing = [axis for axis in axes if axis not in found]
        if missing and len(missing) < len(axes):
            raise InputError(
                f"{where}: column {', '.join(missing)} is missing, expected every axis of {sensor}"
            )
        if not missing:
            sensors[sensor] = axes
    return sensors
