"""The raw readings of a stroke, as series: what figure 3 of [Pen] shows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmark.tasks.task import Series
from estimation.recording import Recording

RAW_SHOWN = ("accel", "ekf")
"""Sensors and estimator of the tasks whose series carry the stroke's raw readings."""

CHANNELS: Mapping[str, tuple[str, str, float]] = MappingProxyType(
    {"accel": ("xyz", "m/s²", 1.0), "gyro": ("xy", "deg/s", 180 / math.pi)}
)
"""Sensor of the turntable → its axes, unit, factor from SI."""


def raw_series(recording: Recording) -> list[Series]:
    """Return every channel over time, named after its sensor and axis: ``raw accel x``."""
    found = []
    for sensor, (axes, unit, factor) in CHANNELS.items():
        for axis, column in zip(axes, recording.readings[sensor].T, strict=True):
            read = np.isfinite(column)
            found.append(
                Series(f"raw {sensor} {axis}", unit, recording.time_s[read], factor * column[read])
            )
    return found
