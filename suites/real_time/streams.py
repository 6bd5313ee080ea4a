"""The streams of the suite real-time, as data: steady writing, simulated and real."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

from benchmark.bodies import BODIES
from estimation.recording import Recording
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from recordings.formats.dpoint import load_dpoint

SECONDS = 8.0
"""Of a simulated stream."""
FOLDER = "dpoint_pen"
SENSORS = ("accel", "gyro", "camera")


@dataclass(frozen=True, eq=False)
class Stream:
    """A model and what its sensors recorded."""

    model: StateSpaceModel
    recording: Recording


@dataclass(frozen=True)
class StreamCase:
    """How to get a stream.

    Parameters
    ----------
    label : for figures
    sensors : that it has
    stream : folder of recordings or None, and a seed → the stream; a real one has no seed
    is_real : needs the folder
    is_judged : whether its sensors hold all states
    """

    label: str
    sensors: str
    stream: Callable[[Path | None, int], Stream]
    is_real: bool = False
    is_judged: bool = True


def simulated(
    body: str, data: Path | None = None, seed: int = 0, seconds: float = SECONDS
) -> Stream:
    """Return a stream of a body of the speed suite."""
    moving = BODIES[body]()
    return Stream(moving.model(), moving.record(seconds, seed))


def recorded(every: int, data: Path | None, seed: int = 0) -> Stream:
    """Return the D-POINT recording with every so-manieth frame of its camera."""
    assert data is not None
    pen = load_pen("dpoint")
    recording = load_dpoint(data / FOLDER, pen).recording.select(SENSORS)
    if every > 1:
        recording = recording.subsampled("camera", every, 0)
    return Stream(pen_model(pen, SENSORS), recording)


IMU, ALL = "accel+gyro", "+".join(SENSORS)
STREAMS: Mapping[str, StreamCase] = MappingProxyType(
    {
        "pen24": StreamCase("pen with camera, simulated", ALL, partial(simulated, "pen24")),
        "turntable": StreamCase("turntable, simulated", IMU, partial(simulated, "turntable")),
        "dpoint-30": StreamCase("D-POINT, 30 Hz", ALL, partial(recorded, 1), is_real=True),
        "dpoint-10": StreamCase("D-POINT, 10 Hz", ALL, partial(recorded, 3), is_real=True),
        "dpoint-3": StreamCase("D-POINT, 3 Hz", ALL, partial(recorded, 10), is_real=True),
        "pen15": StreamCase(
            "pen without camera, simulated", IMU, partial(simulated, "pen15"), is_judged=False
        ),
    }
)
"""Name → stream; Hz are the camera's. A new one is a row here."""


def has_recordings(data: str | None) -> bool:
    """Return whether a folder has what the real streams need."""
    return data is not None and (Path(data) / FOLDER).is_dir()
