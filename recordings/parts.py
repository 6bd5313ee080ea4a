"""The part of a recording that a run uses, of one that comes in parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from estimation.recording import Recording
from models.errors import InputError
from models.sensor_model import SensorModel


@dataclass(frozen=True, eq=False)
class RecordingPart:
    """A part of a recording.

    Parameters
    ----------
    raw : as it was read, with its truth
    recorded : of the sensors of the run
    used : what of them the run is given; None where that is nothing
    """

    raw: Recording
    recorded: Recording
    used: Recording | None


@dataclass(frozen=True, eq=False)
class KeptFrames:
    """Of a camera every m-th frame is kept, from number `phase` on."""

    camera: SensorModel
    every: int
    phase: int


class UsedParts:
    """What a run uses of a recording whose parts pass by.

    Parameters
    ----------
    sensors : names of those that are used
    frames : which are kept; None keeps all
    duration_s : of which the first seconds are used; None uses all

    Raises
    ------
    InputError
        If the duration is not positive; a part without a sensor is refused as it is taken.
    """

    def __init__(
        self,
        sensors: Sequence[str],
        *,
        frames: KeptFrames | None = None,
        duration_s: float | None = None,
    ) -> None:
        if duration_s is not None and not duration_s > 0:
            raise InputError(f"duration is {duration_s:g} s, expected a positive time")
        self._sensors, self._frames, self._duration_s = sensors, frames, duration_s
        self._start_s: float | None = None
        self._frames_before = 0
        self.is_over = False

    def take(self, raw: Recording) -> RecordingPart | None:
        """Return what is used of the next part; None where that is nothing."""
        if self.is_over or not _has_any(raw, self._sensors):
            return None
        recorded = raw.select(self._sensors)
        if self._start_s is None:
            self._start_s = float(recorded.time_s[0])
        if self._duration_s is not None:
            end_s = self._start_s + self._duration_s
            if recorded.time_s[-1] > end_s:
                self.is_over = True
                if recorded.time_s[0] > end_s:
                    return None
                recorded = recorded.some_rows(recorded.time_s <= end_s)
        return RecordingPart(raw, recorded, self._thinned(recorded))

    def _thinned(self, recorded: Recording) -> Recording | None:
        if self._frames is None:
            return recorded
        name, every = self._frames.camera.name, self._frames.every
        frames = len(recorded.sensor(name)[0])
        first = (self._frames.phase - self._frames_before) % every
        self._frames_before += frames
        others = [sensor for sensor in recorded.readings if sensor != name]
        if first >= frames and not _has_any(recorded, others):
            return None
        return recorded.subsampled(name, every, first)


def _has_any(recording: Recording, sensors: Sequence[str]) -> bool:
    return any(len(recording.sensor(name)[0]) > 0 for name in sensors)
