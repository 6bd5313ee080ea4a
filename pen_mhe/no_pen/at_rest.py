"""What a recording shows while it is still: mean readings, noise, and how long that was."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from models.sensor_kinds.inertial import InertialSensor
from pen_mhe.calibration.stills import Still, find_stills
from pen_mhe.no_pen.any_pen import ACCEL

FIRST_ROWS = 10_000
"""Rows in which rest is looked for: a recording that is read in parts has no more at hand."""


LEAST_GRAVITY_M_S2 = 5.0
"""Of the median |f|; less is an acceleration without gravity."""
QUIET = (0.01, 0.05, 0.1)
"""Parts of a recording that may say how quiet it can be, of which that counts which finds most: a
second of rest in a hundred is seen, and a block in which a sensor hangs is not taken for quiet."""


@dataclass(frozen=True, eq=False)
class AtRest:
    """Still stretches of a recording, at least one.

    Parameters
    ----------
    stills : in the order of time
    """

    stills: tuple[Still, ...]

    @property
    def duration_s(self) -> float:
        """How long the recording is still in all, s."""
        return sum(still.duration_s for still in self.stills)

    def mean(self, sensor: str) -> Array:
        """Return the mean reading (n_axes,) of the first stretch."""
        return self.stills[0].mean(sensor)

    def rate_mean(self, sensor: str) -> Array:
        """Return the mean reading (n_axes,) of all stretches, by their lengths."""
        lengths = [len(still.readings[sensor]) for still in self.stills]
        means = [still.mean(sensor) for still in self.stills]
        return np.asarray(np.average(means, axis=0, weights=lengths))

    def noise_std(self, sensor: str) -> Array:
        """Return the deviations (n_axes,) of a reading by noise, from one to the next.

        Differences of neighbours do not count what creeps; a filter in the sensor makes them
        smaller than the spread, so the larger of both is taken.
        """
        spread = [still.readings[sensor].var(axis=0, ddof=1) for still in self.stills]
        steps = [np.mean(np.diff(s.readings[sensor], axis=0) ** 2, axis=0) / 2 for s in self.stills]
        return np.sqrt(np.maximum(np.median(spread, axis=0), np.median(steps, axis=0)))

    def count(self, sensor: str) -> int:
        """Return how many readings were still."""
        return sum(len(still.readings[sensor]) for still in self.stills)


def inertial_of(pen: PenConfig, names: Sequence[str]) -> dict[str, InertialSensor]:
    """Return those of some sensors of a pen that feel gravity or rates, by name."""
    known = ((name, pen.sensors.get(name)) for name in names)
    return {name: sensor for name, sensor in known if isinstance(sensor, InertialSensor)}


def at_rest(recording: Recording, sensors: Mapping[str, InertialSensor]) -> AtRest | None:
    """Return when a recording is still in its first rows; None where it never is.

    Parameters
    ----------
    sensors : of the recording, by name
    """
    if not sensors:
        return None
    found = [still for part in QUIET for still in _stills(recording, sensors, part)]
    return max(found, key=lambda each: each.duration_s, default=None)


def _stills(
    recording: Recording, sensors: Mapping[str, InertialSensor], quiet: float
) -> list[AtRest]:
    try:
        return [AtRest(find_stills([first_rows(recording)], sensors, quiet=quiet).kept)]
    except InputError:  # it is never still, or too short to say
        return []


def has_gravity(recording: Recording) -> bool:
    """Return whether the median of |f| of a recording's accelerometer is near gravity."""
    norm = np.linalg.norm(recording.sensor(ACCEL)[1], axis=1)
    return bool(np.nanmedian(norm) > LEAST_GRAVITY_M_S2)


def first_rows(recording: Recording) -> Recording:
    """Return a recording up to `FIRST_ROWS`."""
    return recording.some_rows(np.arange(min(len(recording.time_s), FIRST_ROWS)))
