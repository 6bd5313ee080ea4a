"""What a recording that is read in parts must be: long enough, no sensor empty, units that fit.

Units are judged from blocks of `BLOCK_ROWS`, so a shorter recording is judged as a whole. Of
several blocks those that tell of a unit vote, each with its rows.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from estimation.recording import Recording
from estimation.recording_parts import joined
from models.errors import InputError
from models.pen_config import PenConfig
from recordings.formats.table_header import TableHeader
from recordings.plausible_units import unit_verdicts

BLOCK_ROWS = 100_000


class RecordingCheck:
    """Checks a recording whose parts pass by; what a table of it had at once, this has at its end.

    Parameters
    ----------
    header : of its table
    """

    def __init__(self, header: TableHeader, pen: PenConfig) -> None:
        self._header, self._units = header, UnitCheck(pen, header.units)
        self._rows, self._empty = 0, dict.fromkeys(header.sensors, True)

    def take(self, part: Recording) -> None:
        """Look at the next part."""
        self._rows += len(part.time_s)
        for sensor, readings in part.readings.items():
            self._empty[sensor] = self._empty[sensor] and bool(np.isnan(readings).all())
        self._units.take(part)

    def end(self) -> None:
        """Raise `InputError` unless the whole is a recording."""
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
    """Checks the units of a recording whose parts pass by; see `recordings.plausible_units`."""

    def __init__(self, pen: PenConfig, read_as: Mapping[str, str]) -> None:
        self._pen, self._read_as = pen, read_as
        self._block: list[Recording] = []
        self._votes: dict[str, int] = {}
        self._refusals: dict[str, InputError] = {}

    def take(self, part: Recording) -> None:
        """Look at the next part."""
        self._block.append(part)
        if sum(len(each.time_s) for each in self._block) >= BLOCK_ROWS:
            self._judge()

    def end(self) -> None:
        """Raise `InputError` for the first sensor that looks as if it had another unit."""
        self._judge()
        for sensor in self._pen.sensors:
            if self._votes.get(sensor, 0) > 0:
                raise self._refusals[sensor]

    def _judge(self) -> None:
        if not self._block:
            return
        block = joined(self._block)
        self._block = []
        for sensor, refusal in unit_verdicts(block, self._pen, read_as=self._read_as).items():
            rows = len(block.time_s)
            self._votes[sensor] = self._votes.get(sensor, 0) + (rows if refusal else -rows)
            if refusal is not None:
                self._refusals.setdefault(sensor, refusal)
