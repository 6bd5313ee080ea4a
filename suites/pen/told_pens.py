"""What the pen of the suite `pen` is told to be: its hand, and what an estimator gets wrong of it.

A free pen is told the hand of its pen file. What is told of a pen that cannot spin, the paper's,
is white jerk with the levels of handwriting (`models.gentle_hand`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

from models.gentle_hand import BY_SPEED
from models.motion import Motion, TipBoundedVelocity, TipWhiteJerk, white_jerk_motion
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.printed import PRINTED_ERRORS

FREE, NO_SPIN = 6, 5
"""Degrees of freedom."""

NEGLIGIBLE = 1e-3
"""Factor of the tip's motion where its accelerations are neglected."""


@dataclass(frozen=True)
class ToldPen:
    """What the reference pen is told to be.

    Parameters
    ----------
    degrees_of_freedom : `FREE` or `NO_SPIN`
    speed : of the handwriting; what is told of the hand follows it
    hand_is_measured : it is told how this handwriting moves, measured on it, instead of the hand
        that the pen file states
    neglects : its accelerometer is taken for one at the tip of a pen whose tip does not
        accelerate, so that it shows gravity and nothing else: what [Pen] does with its turntable
    is_on_axis : all its sensors are on its axis, as (9) has them
    is_printed : its accelerometer is that of (9) as printed, with all its errors
    """

    degrees_of_freedom: int = NO_SPIN
    speed: float = 1.0
    hand_is_measured: bool = False
    neglects: bool = False
    is_on_axis: bool = False
    is_printed: bool = False


FREE_PEN, NO_SPIN_PEN = ToldPen(FREE), ToldPen(NO_SPIN)


@cache
def told_pen(told: ToldPen) -> PenConfig:
    """Return the reference pen as it is told to be."""
    pen = _of_hand(told)
    if told.is_printed:
        return pen.model_copy(update={"printed_errors": PRINTED_ERRORS})
    return _neglecting(pen) if told.neglects else pen


def _of_hand(told: ToldPen) -> PenConfig:
    """Return the reference pen, told how a hand moves it."""
    freedom, speed = told.degrees_of_freedom, told.speed
    pen = load_pen("reference").model_copy(update={"degrees_of_freedom": freedom})
    if told.is_on_axis:
        pen = _on_axis(pen)
    if freedom == NO_SPIN:
        return _moved(pen, _white_jerk(speed), speed)
    return _moved(pen, _measured_hand(speed), speed) if told.hand_is_measured else pen


def _on_axis(pen: PenConfig) -> PenConfig:
    """Return a pen whose sensors are as far from the tip along its axis, and not beside it."""
    sensors: dict[str, Any] = dict(pen.sensors)
    for name, sensor in sensors.items():
        if sensor.is_mounted:
            place = (0.0, 0.0, sensor.position_m[2])
            sensors[name] = sensor.model_copy(update={"position_m": place})
    return pen.model_copy(update={"sensors": MappingProxyType(sensors)})


def _moved(pen: PenConfig, motion: Motion, speed: float) -> PenConfig:
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
