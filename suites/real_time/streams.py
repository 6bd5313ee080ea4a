"""The streams of the real-time study, as data: steady writing, simulated and real."""

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
    label : for tables
    stream : folder of recordings, or None → the stream
    is_real : needs the folder
    is_judged : whether its sensors hold all states
    """

    label: str
    stream: Callable[[Path | None], Stream]
    is_real: bool = False
    is_judged: bool = True


def simulated(body: str, data: Path | None = None, seconds: float = SECONDS) -> Stream:
    """Return a stream of a body of the speed suite."""
    moving = BODIES[body]()
    return Stream(moving.model(), moving.record(seconds, 0))


def recorded(every: int, data: Path | None) -> Stream:
    """Return the D-POINT recording with every so-manieth frame of its camera."""
    assert data is not None
    pen = load_pen("dpoint")
    recording = load_dpoint(data / FOLDER, pen).recording.select(SENSORS)
    if every > 1:
        recording = recording.subsampled("camera", every, 0)
    return Stream(pen_model(pen, SENSORS), recording)


CASES: Mapping[str, StreamCase] = MappingProxyType(
    {
        "pen24": StreamCase("reference pen with camera, simulated", partial(simulated, "pen24")),
        "turntable": StreamCase("turntable, simulated", partial(simulated, "turntable")),
        "dpoint-30": StreamCase("D-POINT, camera at 30 Hz", partial(recorded, 1), is_real=True),
        "dpoint-10": StreamCase("D-POINT, camera at 10 Hz", partial(recorded, 3), is_real=True),
        "dpoint-3": StreamCase("D-POINT, camera at 3 Hz", partial(recorded, 10), is_real=True),
        "pen15": StreamCase(
            "pen without camera, simulated", partial(simulated, "pen15"), is_judged=False
        ),
    }
)
"""Name → stream. A new one is a row here."""


def available(data: Path | None) -> dict[str, StreamCase]:
    """Return the cases that can be run with a folder of recordings, or without one."""
    there = data is not None and (data / FOLDER).is_dir()
    return {name: case for name, case in CASES.items() if there or not case.is_real}
