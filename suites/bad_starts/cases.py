"""The cases of bad starts as data: which pen, how it moves, what its estimator is told.

What is told decides the outcome, more than the start does: a hand that may accelerate the
tip by 3 m/s² leaves no sensor a way to tell tilt from acceleration. See `KNOWLEDGE`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from estimation.recording import Recording
from models.frozen_mapping import FrozenMapping
from models.gentle_hand import BY_SPEED
from models.minimum_jerk import MinimumJerk
from models.motions import motion_named
from models.names import unknown
from models.pen import pen_model
from models.pen_config import PenConfig, Prior, ProcessNoise
from models.pen_file import load_pen
from models.random_streams import seed_sequence, stream
from models.state_space import StateSpaceModel
from recordings.motion_list import DRAWN
from recordings.simulate_pen import simulate, simulate_model

FROM_REST = "strokes from rest"
"""A motion of its own for every seed: rest, then minimum-jerk strokes to drawn points."""

REST_S, STROKE_S = 0.2, 0.4
STROKE_TIP_STD_MM = (10.0, 10.0, 4.0)
STROKE_ANGLES_STD_DEG = (8.0, 5.0, 10.0)
"""Of the points: letters, and the turning of a pen that writes."""

RIGHT_START_STD_RAD = 0.1
"""What is told of a start without error."""


@dataclass(frozen=True)
class Knowledge:
    """What an estimator is told of the hand, the start's elevation aside.

    Parameters
    ----------
    label : for tables
    prior, process_noise : changes of the pen file's, field → value
    biases : False: the sensors have none, and the estimator knows
    """

    label: str
    prior: Mapping[str, float]
    process_noise: Mapping[str, float]
    biases: bool = True


_AT_REST = {
    "velocity_std_m_s": 0.001,
    "angle_rate_std_rad_s": 0.01,
    "acceleration_std_m_s2": 0.01,
    "angle_acceleration_std_rad_s2": 0.1,
}
_GESTURE = {"tip_jerk_density_m_s3_per_sqrt_hz": 2.0, "angle_jerk_density_rad_s3_per_sqrt_hz": 2.0}
_HELD = {"tip_jerk_density_m_s3_per_sqrt_hz": 0.01}


def _at_own_speed(part: str) -> dict[str, float]:
    return {field: value for field, (value, _) in BY_SPEED[part].items()}


KNOWLEDGE: Mapping[str, Knowledge] = MappingProxyType(
    {
        "pen file": Knowledge("the pen file", {}, {}),
        "gentle": Knowledge(
            "how handwriting moves", _at_own_speed("prior"), _at_own_speed("process_noise")
        ),
        "at rest": Knowledge("rest at the start", _AT_REST, {}),
        "gesture": Knowledge("rest at the start, and its jerk", _AT_REST, _GESTURE),
        "held": Knowledge("that it is held", _AT_REST, _HELD),
        "held, unbiased": Knowledge("that it is held, no bias", _AT_REST, _HELD, False),
    }
)
"""Name → what is told; each is true of the motions that it is used with."""


@dataclass(frozen=True)
class BadStart:
    """A case.

    Parameters
    ----------
    label : for tables and figures
    sensors : of the reference pen
    motion : of `models.motions.motions`, `FROM_REST`, or `DRAWN` from the model itself
    knowledge : of `KNOWLEDGE`
    wrong_rad : error of the prior's elevation, with a drawn sign
    told_std_rad : standard deviation of the prior's elevation; None tells `wrong_rad`, but
        at least `RIGHT_START_STD_RAD`
    duration_s : of a run
    degrees_of_freedom : 5 for a pen that does not spin
    rate_axes : the body rates that are judged: those that the sensors see
    """

    label: str
    sensors: tuple[str, ...]
    motion: str
    knowledge: str
    wrong_rad: float = 0.5
    told_std_rad: float | None = None
    duration_s: float = 3.0
    degrees_of_freedom: int = 6
    rate_axes: str = "xyz"

    @property
    def start(self) -> str:
        """The start in words, for tables and figures."""
        told = "" if self.told_std_rad is None else f", told ± {self.told_std_rad:g}"
        return f"{self.wrong_rad:g}{told}"

    @property
    def std_rad(self) -> float:
        """Standard deviation of the elevation that the estimator is told."""
        if self.told_std_rad is not None:
            return self.told_std_rad
        return max(self.wrong_rad, RIGHT_START_STD_RAD)


_WRITING = BadStart("accel + gyro, writing", ("accel", "gyro"), "handwriting", "pen file")
# Two accelerometers on the axis do not see the rate about it.
_STROKES = BadStart(
    "two accels, strokes from rest",
    ("accel_lower", "accel_upper"),
    FROM_REST,
    "at rest",
    rate_axes="xy",
)
_GROUPS: Mapping[str, tuple[BadStart, Sequence[float]]] = {
    "writing": (_WRITING, (0.0, 0.5, 1.0)),
    "too-sure": (replace(_WRITING, told_std_rad=0.25), (0.5,)),
    "unsure": (replace(_WRITING, told_std_rad=1.0), (0.5,)),
    "gentle": (replace(_WRITING, knowledge="gentle"), (0.0, 0.5, 1.0)),
    "held": (
        replace(_WRITING, label="accel + gyro, held still", motion="still", knowledge="held"),
        (0.5, 1.0),
    ),
    "unbiased": (
        replace(
            _WRITING, label="accel + gyro, held still", motion="still", knowledge="held, unbiased"
        ),
        (0.5, 1.0),
    ),
    "strokes": (_STROKES, (0.0, 0.5, 1.0)),
    "no-spin": (
        replace(_STROKES, label="two accels, no spin, strokes from rest", degrees_of_freedom=5),
        (0.0, 0.5, 1.0),
    ),
    # Drawn for a second only: white jerk soon turns a pen head over heels.
    "gesture": (
        replace(
            _STROKES,
            label="two accels, drawn from rest",
            motion=DRAWN,
            knowledge="gesture",
            duration_s=1.0,
        ),
        (0.0, 0.5, 1.0),
    ),
}
CASES: Mapping[str, BadStart] = MappingProxyType(
    {
        f"{group}-{wrong_rad:g}": replace(case, wrong_rad=wrong_rad)
        for group, (case, errors) in _GROUPS.items()
        for wrong_rad in errors
    }
)
"""Name → case: a group and the start's error in rad."""


def case_named(name: str) -> BadStart:
    """Return a case of the table; raises `InputError` for an unknown one."""
    if name not in CASES:
        raise unknown("case", name, CASES)
    return CASES[name]


def case_pen(case: BadStart) -> PenConfig:
    """Return the reference pen with what is known of it in a case."""
    pen, knowledge = load_pen("reference"), KNOWLEDGE[case.knowledge]
    sensors = dict(pen.sensors)
    for name in () if knowledge.biases else case.sensors:
        fields = [field for field in type(sensors[name]).model_fields if field.startswith("bias_")]
        sensors[name] = sensors[name].model_copy(update=dict.fromkeys(fields, 0.0))
    prior, noise = pen.prior.model_dump(), pen.process_noise.model_dump()
    return pen.model_copy(
        update={
            "degrees_of_freedom": case.degrees_of_freedom,
            "prior": Prior.model_validate({**prior, **knowledge.prior}),
            "process_noise": ProcessNoise.model_validate({**noise, **knowledge.process_noise}),
            "sensors": FrozenMapping(sensors),
        }
    )


def case_model(case: BadStart) -> StateSpaceModel:
    """Return the model of a case, with its pen's own elevation."""
    # A truth that is drawn knows of no writing area.
    return pen_model(case_pen(case), case.sensors, writing_area=case.motion != DRAWN)


def case_recording(case: BadStart, seed: int) -> Recording:
    """Return the recording of a seed, with its truth."""
    if case.motion == DRAWN:
        return simulate_model(case_model(case), duration_s=case.duration_s, seed=seed)
    motion = strokes_from_rest(seed) if case.motion == FROM_REST else motion_named(case.motion)
    return simulate(
        case_pen(case), case.sensors, motion=motion, duration_s=case.duration_s, seed=seed
    )


def strokes_from_rest(seed: int, duration_s: float = BadStart.duration_s) -> MinimumJerk:
    """Return a pen that rests for `REST_S` and then moves from one drawn point to the next."""
    n = math.ceil((duration_s - REST_S) / STROKE_S)
    drawn = stream(seed_sequence(seed), "strokes from rest").standard_normal((n, 6))
    away = np.vstack([np.zeros(6), drawn]) * [*STROKE_TIP_STD_MM, *STROKE_ANGLES_STD_DEG]
    held = motion_named("still")
    assert isinstance(held, MinimumJerk)
    return MinimumJerk.model_validate(
        {
            "description": "a pen at rest, then strokes to drawn points",
            "time_s": [REST_S + STROKE_S * k for k in range(n + 1)],
            "tip_mm": away[:, :3].tolist(),
            "angles_deg": (np.degrees(held.angles_rad[0]) + away[:, 3:]).tolist(),
        }
    )
