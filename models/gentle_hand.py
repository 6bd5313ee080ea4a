"""How a hand that writes gently moves, and at what speed: numbers for pen files.

RMS of the motion's derivatives; RMS jerk over the square root of its bandwidth. Played s times
faster, the k-th derivative grows by sᵏ; jerk by s³ and its bandwidth by s.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from models.motion import AttitudeWhiteJerk, Motion, TipBoundedVelocity, white_jerk_motion

BySpeed = Mapping[str, tuple[float, float]]
"""Quantity → (value at its own speed, exponent of the factor it is played at)."""

PRIOR_BY_SPEED: BySpeed = MappingProxyType(
    {
        "velocity_std_m_s": (0.03, 1.0),
        "angle_rate_std_rad_s": (0.3, 1.0),
        "acceleration_std_m_s2": (0.3, 2.0),
        "angle_acceleration_std_rad_s2": (3.0, 2.0),
    }
)
"""Of `models.pen_config.Prior`."""

WHITE_JERK_BY_SPEED: BySpeed = MappingProxyType({"tip": (2.0, 2.5), "attitude": (20.0, 2.5)})
"""Densities for tip (m/s³/√Hz) and Euler angles (rad/s³/√Hz)."""

BOUNDED_BY_SPEED: BySpeed = MappingProxyType(
    {"speed_m_s": (0.03, 1.0), "correlation_time_s": (0.1, -1.0), "attitude": (30.0, 2.5)}
)
"""The tip's speed along an axis, which with this time has an acceleration of 0.3 m/s²; and the
jerk's density (rad/s³/√Hz) about an axis of the body."""


def at_speed(table: BySpeed, speed: float = 1.0) -> dict[str, float]:
    """Return the values of a table of a motion that is played at a factor of its own speed."""
    return {name: value * speed**exponent for name, (value, exponent) in table.items()}


def white_jerk_writing(speed: float = 1.0) -> Motion:
    """Return what drives a pen with Euler rates that writes."""
    return white_jerk_motion(**at_speed(WHITE_JERK_BY_SPEED, speed))


def bounded_writing(speed: float = 1.0) -> Motion:
    """Return what drives a free pen that writes: it does not get fast."""
    values = at_speed(BOUNDED_BY_SPEED, speed)
    attitude = AttitudeWhiteJerk(jerk_density_rad_s3_per_sqrt_hz=values.pop("attitude"))
    return Motion(tip=TipBoundedVelocity(**values), attitude=attitude)
