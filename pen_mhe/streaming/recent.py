"""The last parts of a recording: what the rows of a run that still come may speak of."""

from __future__ import annotations

import numpy as np

from estimation.recording_parts import joined_truth
from estimation.truth import Truth
from models.arrays import Array
from recordings.parts import RecordingPart


class Recent:
    """The parts of a recording from some instant on.

    Parameters
    ----------
    sensor : whose instants are asked for
    """

    def __init__(self, sensor: str) -> None:
        self._sensor, self._parts = sensor, list[tuple[RecordingPart, Array]]()

    def add(self, part: RecordingPart) -> None:
        """Keep the next part."""
        none = np.zeros(0)
        times = none if part.used is None else part.used.sensor(self._sensor)[0]
        self._parts.append((part, times))

    def forget(self, before_s: float) -> None:
        """Drop the parts that end before an instant; the last one stays."""
        while len(self._parts) > 1 and self._parts[0][0].raw.time_s[-1] < before_s:
            del self._parts[0]

    @property
    def times(self) -> Array:
        """(n,) instants at which the sensor has a reading that is used."""
        return np.concatenate([times for _, times in self._parts])

    @property
    def truth(self) -> Truth | None:
        """The truth, where the recording has it."""
        return joined_truth([part.raw.truth for part, _ in self._parts if part.raw.truth])
