"""Halves of a recording: what is fitted on one is scored on the other."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel

PARTS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"all": (0.0, 1.0), "first-half": (0.0, 0.5), "second-half": (0.5, 1.0)}
)
"""Name → which part of a recording's time it is."""

SETTLING_S = 2.0
"""At the start of a part, while the filter forgets its prior; not scored."""


@dataclass(frozen=True, eq=False)
class ScoredPart:
    """A part of a recording as objectives see it.

    Parameters
    ----------
    recording : up to the part's end, with all sensors that it has
    counts_from_s : the instant from which on the part is scored: the filter comes to it with
        what was before, and not from its prior
    pen : as its file is
    model : of the sensors that are used
    """

    recording: Recording
    counts_from_s: float
    pen: PenConfig
    model: StateSpaceModel

    @classmethod
    def of(
        cls, recording: Recording, part: str, *, pen: PenConfig, model: StateSpaceModel
    ) -> ScoredPart:
        """Return a part, one of `PARTS`, without truth and without anything that comes later.

        Raises
        ------
        InputError
            If the part is too short for the filter to settle and be scored.
        """
        first, last = recording.time_s[0], recording.time_s[-1]
        low, high = (first + share * (last - first) for share in PARTS[part])
        kept = (recording.time_s < high) | (PARTS[part][1] == 1.0)
        if high - low <= 2 * SETTLING_S:
            raise InputError(
                f"recording {recording.name}: its part {part} lasts {high - low:.3g} s, "
                f"expected more than {2 * SETTLING_S:g} s"
            )
        until = dataclasses.replace(recording.some_rows(kept), truth=None)
        return cls(until, float(low) + SETTLING_S, pen, model)

    @cached_property
    def stacked(self) -> tuple[Array, Array]:
        """Times (n,) and readings (n, n_y) of the sensors that are used."""
        used = self.recording.select([sensor.name for sensor in self.model.measured_sensors])
        return used.stacked(self.model)

    @cached_property
    def touches_s(self) -> Array:
        """(m,) instants at which a sensor of the pen says that the tip touches."""
        found = [
            self.recording.sensor(name)[0]
            for name, sensor in self.pen.sensors.items()
            if sensor.reads_touch and name in self.recording.readings
        ]
        times = np.unique(np.concatenate([np.zeros(0), *found]))
        return times[times >= self.counts_from_s]

    def without(self, sensors: Sequence[str], hidden: NDArray[np.bool_]) -> Array:
        """Return the readings (n, n_y) without those of some sensors at some instants (n,)."""
        y, start = self.stacked[1].copy(), 0
        for sensor in self.model.sensors:
            if sensor.name in sensors:
                y[hidden, start : start + sensor.n_y] = np.nan
            start += sensor.n_y
        return y

    @cached_property
    def cameras(self) -> tuple[SensorModel, ...]:
        """The sensors that see the pose."""
        return tuple(sensor for sensor in self.model.sensors if sensor.sees_pose)

    def frames(self, camera: SensorModel) -> tuple[NDArray[np.int_], Array]:
        """Return at which instants of `stacked` a camera has frames, and the frames."""
        times, readings = self.recording.sensor(camera.name)
        return np.searchsorted(self.stacked[0], times), readings
