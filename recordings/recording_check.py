"""What a recording must be: long enough, no sensor empty, units that fit; whole or in parts.

Units are judged from blocks of `BLOCK_ROWS`, so a shorter recording is judged as a whole. Of
several blocks those that tell of a unit vote, each with its rows.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from estimation.arrivals import has_reading
from estimation.recording import Recording
from estimation.recording_parts import joined
from models.errors import InputError
from models.pen_config import PenConfig
from recordings.foreign.header_units import KNOWN_UNITS
from recordings.foreign.time_units import check_time_unit
from recordings.formats.columns import TIME
from recordings.formats.table_header import TableHeader
from recordings.plausible_units import spread, unit_verdicts
from recordings.unfit import unfit

BLOCK_ROWS = 100_000


class RecordingCheck:
    """Checks a recording whose parts pass by; what a table of it had at once, this has at its end.

    Parameters
    ----------
    header : of its table
    """

    def __init__(self, header: TableHeader, pen: PenConfig) -> None:
        self._header = header
        self._units = UnitCheck(pen, header.units, stamps=header.stamps)
        self._rows, self._empty = 0, dict.fromkeys(header.sensors, True)

    def take(self, part: Recording) -> None:
        """Look at the next part."""
        self._rows += len(part.time_s)
        for sensor, readings in part.readings.items():
            self._empty[sensor] = self._empty[sensor] and bool(np.isnan(readings).all())
        self._units.take(part)

    def end(self) -> None:
        """Raise `UnfitTableError` unless the whole is a recording."""
        with unfit():
            self._end()

    def _end(self) -> None:
        where = self._header.where
        if not self._rows:
            raise InputError(f"{where} is empty below its header, expected at least one sample")
        for sensor, is_empty in self._empty.items():
            if is_empty:
                raise self._header.empty(sensor)
        self._units.end()
        if self._rows < 2:
            raise InputError(f"{where} has a single sample, expected at least two")


class UnitCheck:
    """Checks the units of a recording whose parts pass by; see `recordings.plausible_units`.

    Parameters
    ----------
    read_as : sensor → the unit that its columns were read in
    stamps : header of the times, and their unit; None does not judge it
    """

    def __init__(
        self, pen: PenConfig, read_as: Mapping[str, str], *, stamps: tuple[str, str] | None = None
    ) -> None:
        self._pen, self._read_as, self._stamps = pen, read_as, stamps
        self._block: list[Recording] = []
        self._votes: dict[str, int] = {}
        self._refusals: dict[str, InputError] = {}

    def take(self, part: Recording) -> None:
        """Look at the next part."""
        self._block.append(part)
        if sum(len(each.time_s) for each in self._block) >= BLOCK_ROWS:
            self._judge()

    def end(self) -> None:
        """Raise `InputError` for times, or the first sensor, that look as if in another unit."""
        self._judge()
        for judged in (TIME, *self._pen.sensors):
            if self._votes.get(judged, 0) > 0:
                raise self._refusals[judged]

    def _judge(self) -> None:
        if not self._block:
            return
        block = joined(self._block) if len(self._block) > 1 else self._block[0]
        self._block = []
        verdicts = unit_verdicts(block, self._pen, read_as=self._read_as)
        for judged, refusal in {TIME: self._time_verdict(block), **verdicts}.items():
            rows = len(block.time_s)
            self._votes[judged] = self._votes.get(judged, 0) + (rows if refusal else -rows)
            if refusal is not None:
                self._refusals.setdefault(judged, refusal)

    def _time_verdict(self, block: Recording) -> InputError | None:
        """Return the refusal of times in a unit in which no inertial sensor has such a rate."""
        if self._stamps is None:
            return None
        header, unit = self._stamps
        rows = spread(len(block.time_s))
        for name, readings in block.readings.items():
            sensor = self._pen.sensors[name]
            if sensor.feels_gravity or sensor.reads_rate:
                time_s = block.time_s[rows][has_reading(readings[rows])]
                where = f"recording {block.name}"
                try:
                    check_time_unit(header, KNOWN_UNITS[unit], time_s, where)
                except InputError as refusal:
                    return refusal
        return None
