"""A recording as what arrives, a reading each; what arrives after an instant, changed at random."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from estimation.recording import Recording
from models.arrays import Array


@dataclass(frozen=True, eq=False)
class Reading:
    """One sensor's reading: when it was captured, when it arrives (s), what it is (n_y,)."""

    sensor: str
    capture_s: float
    arrival_s: float
    y: Array


def readings_of(recording: Recording, rng: np.random.Generator, late: str) -> list[Reading]:
    """Return a recording's readings; those of the sensor `late` arrive 20 to 60 ms later."""
    found = []
    for name in recording.readings:
        for capture_s, y in zip(*recording.sensor(name), strict=True):
            delay_s = rng.uniform(0.02, 0.06) if name == late else 0.0
            found.append(Reading(name, float(capture_s), round(float(capture_s) + delay_s, 9), y))
    return found


def recording_of(
    name: str, readings: list[Reading], inputs: Mapping[str, tuple[Array, Array]] | None = None
) -> Recording:
    """Return the recording of some readings, with their arrivals, and of known inputs."""
    ordered = sorted(readings, key=lambda each: each.capture_s)
    sensors, arrivals = {}, {}
    for sensor in sorted({each.sensor for each in ordered}):
        own = [each for each in ordered if each.sensor == sensor]
        sensors[sensor] = (np.array([r.capture_s for r in own]), np.array([r.y for r in own]))
        arrivals[sensor] = np.array([each.arrival_s for each in own])
    return Recording.from_sensors(name, sensors, inputs=inputs, arrivals=arrivals)


def changed_after(
    readings: list[Reading], after_s: float, rng: np.random.Generator
) -> list[Reading]:
    """Return readings with all that arrives after an instant changed.

    Values, presence, order and arrival: a third of the readings is gone, others arrive at any time
    after the instant, there are new ones with captures before it.
    """
    kept = [each for each in readings if each.arrival_s <= after_s]
    end_s = max(each.arrival_s for each in readings)
    later = [each for each in readings if each.arrival_s > after_s and rng.random() > 1 / 3]
    moved = [
        Reading(
            each.sensor,
            each.capture_s,
            round(max(each.capture_s, rng.uniform(after_s, end_s)) + 1e-6, 9),
            each.y * rng.uniform(0.5, 2.0, each.y.shape),
        )
        for each in later
    ]
    new = [
        Reading(
            each.sensor,
            round(rng.uniform(0.0, after_s), 9),
            round(after_s + rng.uniform(1e-6, 0.05), 9),
            each.y + rng.standard_normal(each.y.shape),
        )
        for each in rng.choice(np.array(readings, dtype=object), size=5)
    ]
    return [*kept, *moved, *new]
