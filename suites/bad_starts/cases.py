"""The cases of bad starts as data: which pen, how it moves, what its estimator is told.

What is told decides the outcome, more than the start does: a hand that may accelerate the
tip by 3 m/s² leaves no sensor a way to tell tilt from acceleration. See `KNOWLEDGE`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from types import MappingProxyType

from estimation.recording import Recording
from models.frozen_mapping import FrozenMapping
from models.gentle_hand import at_speed, bounded_writing
from models.motion import Motion, TipWhiteJerk, white_jerk_motion
from models.motions import motion_named
from models.names import unknown
from models.pen import pen_model
from models.pen_config import PenConfig, Prior
from models.pen_file import load_pen
from models.sensor_kinds.table import Sensor
from models.state_space import StateSpaceModel
from recordings.motion_list import DRAWN
from recordings.simulate_pen import simulate, simulate_model
from suites.bad_starts.strokes import FROM_REST, strokes_from_rest

RIGHT_START_STD_DEG = 5.0
"""What is told of a start without error."""


@dataclass(frozen=True)
class Knowledge:
    """What an estimator is told of the hand, the start's attitude aside.

    Parameters
    ----------
    label : for tables
    prior : changes of the pen file's, field → value
    motion : in place of the pen file's
    tip : in place of its tip's alone
    bias_std_m_s2 : of the accelerometers, in place of the pen file's; 0 leaves no sensor a bias,
        and the estimator knows
    """

    label: str
    prior: Mapping[str, float] = field(default_factory=FrozenMapping)
    motion: Motion | None = None
    tip: TipWhiteJerk | None = None
    bias_std_m_s2: float | None = None


_AT_REST = {
    "velocity_std_m_s": 0.001,
    "angle_rate_std_rad_s": 0.01,
    "acceleration_std_m_s2": 0.01,
    "angle_acceleration_std_rad_s2": 0.1,
}
_STROKES_MOTION = white_jerk_motion(tip=10.0, attitude=20.0)
"""Of `FROM_REST`: a hand that is at rest and then is not has no speed that stays."""

_HELD = TipWhiteJerk(jerk_density_m_s3_per_sqrt_hz=0.01)

KNOWLEDGE: Mapping[str, Knowledge] = MappingProxyType(
    {
        "pen file": Knowledge("the pen file"),
        "calibrated": Knowledge("the pen file, bias ± 0.1 m/s²", bias_std_m_s2=0.1),
        "gentle": Knowledge("how handwriting moves", at_speed("prior"), bounded_writing()),
        "at rest": Knowledge("rest at the start", _AT_REST, _STROKES_MOTION),
        "gesture": Knowledge(
            "rest at the start, and its jerk", _AT_REST, white_jerk_motion(tip=2.0, attitude=2.0)
        ),
        "held": Knowledge("that it is held", _AT_REST, tip=_HELD),
        "held, unbiased": Knowledge(
            "that it is held, no bias", _AT_REST, tip=_HELD, bias_std_m_s2=0.0
        ),
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
    wrong_deg : the prior's attitude is the true one, turned that far about a drawn axis; of a
        pen that does not spin the elevation is wrong, with a drawn sign
    told_std_deg : standard deviation of the prior's attitude about every axis, or of its
        elevation; None tells `wrong_deg`, but at least `RIGHT_START_STD_DEG`
    duration_s : of a run
    degrees_of_freedom : 5 for a pen that does not spin
    rate_axes : the body rates that are judged: those that the sensors see
    """

    label: str
    sensors: tuple[str, ...]
    motion: str
    knowledge: str
    wrong_deg: float = 30.0
    told_std_deg: float | None = None
    duration_s: float = 3.0
    degrees_of_freedom: int = 6
    rate_axes: str = "xyz"

    @property
    def start(self) -> str:
        """The start in words, for tables and figures."""
        told = "" if self.told_std_deg is None else f", told ± {self.told_std_deg:g}"
        return f"{self.wrong_deg:g}{told}"

    @property
    def std_rad(self) -> float:
        """Standard deviation, rad, that the estimator is told."""
        if self.told_std_deg is not None:
            return math.radians(self.told_std_deg)
        return math.radians(max(self.wrong_deg, RIGHT_START_STD_DEG))


_WRITING = BadStart(
    "accel + gyro, writing", ("accel", "gyro"), "handwriting", "pen file", duration_s=5.0
)
_HELD_STILL = replace(
    _WRITING, label="accel + gyro, held still", motion="still", knowledge="held", duration_s=3.0
)
# Two accelerometers on the axis do not see the rate about it.
_STROKES = BadStart(
    "two accels, strokes from rest",
    ("accel_lower", "accel_upper"),
    FROM_REST,
    "at rest",
    rate_axes="xy",
)
_ALL_ROUND = (0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 170.0)
_GROUPS: Mapping[str, tuple[BadStart, Sequence[float]]] = {
    "writing": (_WRITING, _ALL_ROUND),
    "calibrated": (replace(_WRITING, knowledge="calibrated"), _ALL_ROUND),
    "too-sure": (replace(_WRITING, told_std_deg=15.0), (30.0,)),
    "unsure": (replace(_WRITING, told_std_deg=60.0), (30.0,)),
    "gentle": (replace(_WRITING, knowledge="gentle"), (0.0, 30.0, 60.0)),
    "held": (_HELD_STILL, (30.0, 60.0)),
    "unbiased": (replace(_HELD_STILL, knowledge="held, unbiased"), (30.0, 60.0)),
    "strokes": (_STROKES, (0.0, 30.0, 60.0)),
    "no-spin": (
        replace(_STROKES, label="two accels, no spin, strokes from rest", degrees_of_freedom=5),
        (0.0, 30.0, 60.0),
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
        (0.0, 30.0, 60.0),
    ),
}
CASES: Mapping[str, BadStart] = MappingProxyType(
    {
        f"{group}-{wrong_deg:g}": replace(case, wrong_deg=wrong_deg)
        for group, (case, errors) in _GROUPS.items()
        for wrong_deg in errors
    }
)
"""Name → case: a group and the start's error in degrees."""


def case_named(name: str) -> BadStart:
    """Return a case of the table; raises `InputError` for an unknown one."""
    if name not in CASES:
        raise unknown("case", name, CASES)
    return CASES[name]


def case_pen(case: BadStart) -> PenConfig:
    """Return the reference pen with what is known of it in a case."""
    pen, knowledge = load_pen("reference"), KNOWLEDGE[case.knowledge]
    motion = knowledge.motion or pen.motion
    if knowledge.tip is not None:
        motion = motion.model_copy(update={"tip": knowledge.tip})
    return pen.model_copy(
        update={
            "degrees_of_freedom": case.degrees_of_freedom,
            "prior": Prior.model_validate({**pen.prior.model_dump(), **knowledge.prior}),
            "motion": motion,
            "sensors": FrozenMapping(_with_bias(pen.sensors, knowledge.bias_std_m_s2)),
        }
    )


def _with_bias(sensors: Mapping[str, Sensor], std_m_s2: float | None) -> dict[str, Sensor]:
    """Return sensors with another bias of the accelerometers; 0 takes every sensor's."""
    changed = dict(sensors)
    if std_m_s2 is None:
        return changed
    for name, sensor in sensors.items():
        fields = [
            field
            for field in type(sensor).model_fields
            if field.startswith(("bias_std_", "bias_walk_"))
        ]
        if std_m_s2 == 0.0:
            changed[name] = sensor.model_copy(update=dict.fromkeys(fields, 0.0))
        elif "bias_std_m_s2" in fields:
            changed[name] = sensor.model_copy(update={"bias_std_m_s2": std_m_s2})
    return changed


def case_model(case: BadStart) -> StateSpaceModel:
    """Return the model of a case, with its pen's own attitude."""
    return _kept_model(replace(case, label="", wrong_deg=0.0, told_std_deg=None, duration_s=0.0))


@lru_cache(maxsize=16)
def _kept_model(case: BadStart) -> StateSpaceModel:
    """Return a model that serves every start of a case."""
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
