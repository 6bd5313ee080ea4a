"""The problems of the suite, as data: a model, a recording to cut windows from, a horizon.

A problem's name is that of its model; with its horizon it makes the key ``pen15_20``
under which results and files go.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from benchmark.registry import find_pen
from benchmark.simulate import simulate_recording
from benchmark.simulate_turntable import simulate_table
from estimation.recording import Recording
from models.errors import InputError
from models.pen import PenConfig, pen_model
from models.sensors import Sensor
from models.state_space import StateSpaceModel
from models.turntable import TurntableConfig, paper_turntable, turntable_model

NO_BIAS: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {
        "accel": {"bias_std_m_s2": 0.0, "bias_walk_m_s2_per_sqrt_s": 0.0},
        "gyro": {"bias_std_rad_s": 0.0, "bias_walk_rad_s_per_sqrt_s": 0.0, "axes": ("x", "y")},
    }
)
"""Sensor → what becomes of it in the pen of [Pen]: no bias states, and no third rate."""

MOTION = "handwriting"
DURATION_S = 12.0
"""Of a problem's recording: fixed, so that the first windows are the same in any number."""


@dataclass(frozen=True)
class Body:
    """What moves: how to write down its model, and how to record it.

    Parameters
    ----------
    config : the pen or turntable as data, with the sensors that are used and no other
    model : the state-space model
    record : duration (s) and seed → a simulated recording
    """

    config: PenConfig | TurntableConfig
    model: Callable[[], StateSpaceModel]
    record: Callable[[float, int], Recording]


@dataclass(frozen=True)
class Problem:
    """Windows of one length from one recording.

    Parameters
    ----------
    name : a key of `BODIES`
    horizon : N, intervals of a window
    windows : how many are timed; more narrows the median and takes longer
    seed : of the recording
    """

    name: str
    horizon: int
    windows: int
    seed: int = 0

    @property
    def key(self) -> str:
        """Name and horizon: ``pen15_20``."""
        return f"{self.name}_{self.horizon}"

    @property
    def body(self) -> Body:
        """What moves."""
        return BODIES[self.name]()


def _pen_body(pen: PenConfig) -> Body:
    return Body(
        pen,
        # The sensors as they are: a writing area would be a sixth to eighth row.
        lambda: pen_model(pen, writing_area=False),
        lambda duration_s, seed: simulate_recording(pen, None, MOTION, duration_s, seed),
    )


def _turntable() -> Body:
    table = paper_turntable()
    return Body(
        table,
        lambda: turntable_model(table),
        lambda duration_s, seed: simulate_table(table, duration_s, seed),
    )


def _pen15() -> Body:
    """Five degrees of freedom, (1) and (9) of [Pen]: 15 states, 5 rows, no bias."""
    pen = find_pen("reference")
    sensors: dict[str, Sensor] = {
        name: pen.sensors[name].model_copy(update=dict(change)) for name, change in NO_BIAS.items()
    }
    return _pen_body(pen.model_copy(update={"degrees_of_freedom": 5, "sensors": sensors}))


def _pen24() -> Body:
    """Six degrees of freedom and six biases: 24 states; a camera at its own rate of 30 Hz."""
    pen = find_pen("reference")
    sensors = {name: pen.sensors[name] for name in ("accel", "gyro", "camera")}
    return _pen_body(pen.model_copy(update={"sensors": sensors}))


BODIES: Mapping[str, Callable[[], Body]] = MappingProxyType(
    {"turntable": _turntable, "pen15": _pen15, "pen24": _pen24}
)
"""Name → what moves."""

PROBLEMS: tuple[Problem, ...] = (
    Problem("turntable", 20, 200),
    Problem("pen15", 20, 200),
    Problem("pen15", 100, 60),
    Problem("pen15", 500, 20),
    Problem("pen24", 60, 60),
)
"""The suite."""


def find_problem(key: str) -> Problem:
    """Return a problem by its key; raises `InputError` for an unknown one."""
    for problem in PROBLEMS:
        if problem.key == key:
            return problem
    known = ", ".join(problem.key for problem in PROBLEMS)
    raise InputError(f"problem {key} is unknown, expected one of {known}")
