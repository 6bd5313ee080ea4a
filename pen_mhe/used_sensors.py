"""Which sensors of a pen a run uses: those that the recording has, and rest as it is told."""

from __future__ import annotations

from collections.abc import Sequence

from estimation.recording import Recording
from models.pen_config import PenConfig


def default_sensors(pen: PenConfig, recording: Recording) -> tuple[str, ...]:
    """Return the pen's sensors that the recording has."""
    return tuple(name for name in pen.sensors if name in recording.readings)


def with_told_rest(
    pen: PenConfig, recording: Recording, sensors: Sequence[str]
) -> tuple[PenConfig, tuple[str, ...]]:
    """Return pen and sensors with rest as the recording tells it; as they are where it does not.

    The pen's sensor of rest is then read instead of detected, and goes with any gyroscope.
    """
    told = {
        name: sensor.model_copy(update={"is_detected": False})
        for name, sensor in pen.sensors.items()
        if sensor.makes_readings and name in recording.readings
    }
    has_rate = any(pen.sensors[name].reads_rate for name in sensors if name in pen.sensors)
    more = [name for name in told if has_rate and name not in sensors]
    return pen.model_copy(update={"sensors": {**pen.sensors, **told}}), (*sensors, *more)
