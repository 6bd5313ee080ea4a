"""The whole pen in the suite `pen`: how it moves, and what its estimator takes it for.

A free pen is told the hand of its pen file. What is told of a pen that cannot spin, the paper's,
is white jerk with the levels of handwriting (`models.gentle_hand`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

from benchmark.configurations import BENCHMARK_ESTIMATORS, CONFIGURATIONS
from benchmark.from_mhe import NEAR
from benchmark.from_mhe import REFERENCE as OPTIMUM
from models.gentle_hand import BY_SPEED
from models.motion import Motion, TipBoundedVelocity, TipWhiteJerk, white_jerk_motion
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.printed import PRINTED_ERRORS
from suites.pen_quantities import SETTLING_S

PEN_ESTIMATORS = BENCHMARK_ESTIMATORS
MOTION, DURATION_S = "handwriting", 4.0

WITH_IPOPT_S, WITH_IPOPT_SETTLING_S = 0.5, 0.25
"""Stretch of the recording that IPOPT solves too. An accelerometer alone takes it 45 ms a step
there, but up to 300 iterations and 1.8 s from 0.6 s on."""

BOTH = ("accel+gyro",)
FREE, NO_SPIN = 6, 5
"""Degrees of freedom."""


@dataclass(frozen=True)
class PenCase:
    """A case.

    Parameters
    ----------
    about : what it shows, for people
    sensors : keys of `benchmark.configurations.CONFIGURATIONS`
    speed : at which the handwriting is played; what is told of the hand follows it
    degrees_of_freedom : of the pen that moves
    assumed : degrees of freedom of the estimator's pen
    hand_is_measured : the estimator is told how this handwriting moves, measured on it, instead
        of the hand that the pen file states
    estimators : that run on it
    duration_s, settling_s : of the recording, and its begin that errors leave out
    has_few_seeds : it takes long, see `benchmark.tasks.suite.Scope`
    neglects : the estimator takes the accelerometer for one at the tip of a pen whose tip
        does not accelerate, so that it shows gravity and nothing else: what [Pen] does with
        its turntable
    is_on_axis : all its sensors are on its axis, as (9) has them
    is_printed : the estimator's accelerometer is that of (9) as printed, with all its errors
    """

    about: str
    sensors: tuple[str, ...]
    speed: float = 1.0
    degrees_of_freedom: int = NO_SPIN
    assumed: int = NO_SPIN
    hand_is_measured: bool = False
    estimators: tuple[str, ...] = PEN_ESTIMATORS
    duration_s: float = DURATION_S
    settling_s: float = SETTLING_S
    has_few_seeds: bool = False
    neglects: bool = False
    is_on_axis: bool = False
    is_printed: bool = False


REFERENCE, WITHOUT_SPIN = "free pen, handwriting", "no-spin pen, handwriting"
WITH_IPOPT = f"free pen, handwriting, {WITH_IPOPT_S:g} s"
ON_AXIS, PRINTED = "no-spin pen, rigid body", "no-spin pen, (9) as printed"
ON_AXIS_BEGIN, PRINTED_BEGIN = (f"{case}, {WITH_IPOPT_S:g} s" for case in (ON_AXIS, PRINTED))
SPIN_IGNORED, MEASURED_HAND = "spin ignored", "free pen, hand measured"

PEN_CASES: Mapping[str, PenCase] = MappingProxyType(
    {
        REFERENCE: PenCase(
            "a pen that spins", tuple(CONFIGURATIONS), 1.0, FREE, FREE,
            estimators=("ukf", *PEN_ESTIMATORS),
        ),
        WITH_IPOPT: PenCase(
            "how far `mhe` is from the optimum", tuple(CONFIGURATIONS), 1.0, FREE, FREE,
            estimators=(OPTIMUM, NEAR), duration_s=WITH_IPOPT_S,
            settling_s=WITH_IPOPT_SETTLING_S, has_few_seeds=True,
        ),
        MEASURED_HAND: PenCase(
            "what it is worth to know the hand", BOTH, 1.0, FREE, FREE, hand_is_measured=True,
            estimators=("ekf",),
        ),
        **{
            case: PenCase(
                "what the errors of (9) cost", (*BOTH, "accel+gyro+camera"),
                estimators=("mhe-rti", "ekf"), is_on_axis=True, is_printed=case == PRINTED,
            )
            for case in (ON_AXIS, PRINTED)
        },
        **{
            case: PenCase(
                "the same on the stretch that IPOPT solves too", ("accel+gyro+camera",),
                estimators=(OPTIMUM, NEAR, "mhe-rti", "ekf"), duration_s=WITH_IPOPT_S,
                settling_s=WITH_IPOPT_SETTLING_S, has_few_seeds=True, is_on_axis=True,
                is_printed=case == PRINTED_BEGIN,
            )
            for case in (ON_AXIS_BEGIN, PRINTED_BEGIN)
        },
        SPIN_IGNORED: PenCase(
            "a pen that spins, taken for one that does not",
            ("gyro", "accel+gyro", "accel+gyro+camera"),
            degrees_of_freedom=FREE,
        ),
        WITHOUT_SPIN: PenCase("the paper's pen, which cannot spin", tuple(CONFIGURATIONS)),
        **{
            f"rigid body, speed {speed:g}": PenCase(
                "the same handwriting at another speed", BOTH, speed
            )
            for speed in (0.1, 0.3, 3.0)
        },
        **{
            f"accelerations neglected, speed {speed:g}": PenCase(
                "the accelerometer taken for gravity alone", BOTH, speed, neglects=True
            )
            for speed in (0.1, 0.3, 1.0, 3.0)
        },
    }
)  # fmt: skip
"""Name → case."""

NEGLIGIBLE = 1e-3
"""Factor of the tip's motion where its accelerations are neglected."""


@cache
def moving_pen(case: str) -> PenConfig:
    """Return the pen that moves in a case, told its hand."""
    return _of_hand(PEN_CASES[case], PEN_CASES[case].degrees_of_freedom)


@cache
def assumed_pen(case: str) -> PenConfig:
    """Return the pen that the estimator of a case assumes."""
    row = PEN_CASES[case]
    pen = _of_hand(row, row.assumed)
    if row.is_printed:
        return pen.model_copy(update={"printed_errors": PRINTED_ERRORS})
    return _neglecting(pen) if row.neglects else pen


@cache
def like(case: str) -> str:
    """Return the first case whose estimators assume the same pen: they are the same ones."""
    return next(name for name in PEN_CASES if assumed_pen(name) == assumed_pen(case))


def _of_hand(row: PenCase, degrees_of_freedom: int) -> PenConfig:
    """Return the reference pen, told how the hand of a case moves it."""
    pen = load_pen("reference").model_copy(update={"degrees_of_freedom": degrees_of_freedom})
    if row.is_on_axis:
        pen = _on_axis(pen)
    if degrees_of_freedom == NO_SPIN:
        return _told(pen, _white_jerk(row.speed), row.speed)
    return _told(pen, _measured_hand(row.speed), row.speed) if row.hand_is_measured else pen


def _on_axis(pen: PenConfig) -> PenConfig:
    """Return a pen whose sensors are as far from the tip along its axis, and not beside it."""
    sensors: dict[str, Any] = dict(pen.sensors)
    for name, sensor in sensors.items():
        if sensor.is_mounted:
            place = (0.0, 0.0, sensor.position_m[2])
            sensors[name] = sensor.model_copy(update={"position_m": place})
    return pen.model_copy(update={"sensors": MappingProxyType(sensors)})


def _told(pen: PenConfig, motion: Motion, speed: float) -> PenConfig:
    """Return a pen that is told a motion, and the first rates and accelerations of handwriting."""
    return pen.model_copy(
        update={"motion": motion, "prior": pen.prior.model_copy(update=_at("prior", speed))}
    )


def _at(part: str, speed: float) -> dict[str, float]:
    """Return a part of `BY_SPEED` at a speed."""
    return {name: value * speed**exponent for name, (value, exponent) in BY_SPEED[part].items()}


def _white_jerk(speed: float) -> Motion:
    levels = _at("process_noise", speed)
    return white_jerk_motion(
        levels["tip_jerk_density_m_s3_per_sqrt_hz"], levels["angle_jerk_density_rad_s3_per_sqrt_hz"]
    )


def _measured_hand(speed: float) -> Motion:
    """Return the bounded velocity with the RMS velocity and acceleration of handwriting."""
    tip = _at("prior", speed)
    velocity, acceleration = tip["velocity_std_m_s"], tip["acceleration_std_m_s2"]
    return _white_jerk(speed).model_copy(
        update={
            "tip": TipBoundedVelocity(
                speed_m_s=velocity, correlation_time_s=velocity / acceleration
            )
        }
    )


def _neglecting(pen: PenConfig) -> PenConfig:
    """Return a pen of white jerk whose accelerometer sits at a tip that hardly accelerates."""
    prior, motion = pen.prior, pen.motion
    assert isinstance(motion.tip, TipWhiteJerk)
    density = NEGLIGIBLE * motion.tip.jerk_density_m_s3_per_sqrt_hz
    sensors = {
        name: sensor.model_copy(update={"position_m": (0.0, 0.0, 0.0)})
        if sensor.is_mounted
        else sensor
        for name, sensor in pen.sensors.items()
    }
    slow: dict[str, Any] = {
        "velocity_std_m_s": NEGLIGIBLE * prior.velocity_std_m_s,
        "acceleration_std_m_s2": NEGLIGIBLE * prior.acceleration_std_m_s2,
    }
    tip = TipWhiteJerk(jerk_density_m_s3_per_sqrt_hz=density)
    return pen.model_copy(
        update={
            "prior": prior.model_copy(update=slow),
            "motion": motion.model_copy(update={"tip": tip}),
            "sensors": MappingProxyType(sensors),
        }
    )
