"""How a hand that writes gently moves, and at what speed: numbers for pen files.

RMS of the motion's derivatives; RMS jerk over the square root of its bandwidth. Played s times
faster, the k-th derivative grows by sᵏ; jerk by s³ and its bandwidth by s.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from models.motion import AttitudeWhiteJerk, Motion, TipBoundedVelocity, white_jerk_motion

BY_SPEED: Mapping[str, Mapping[str, tuple[float, float]]] = MappingProxyType(
    {
        "process_noise": {
            "tip_jerk_density_m_s3_per_sqrt_hz": (2.0, 2.5),
            "angle_jerk_density_rad_s3_per_sqrt_hz": (20.0, 2.5),
        },
        "free": {
            "speed_m_s": (0.03, 1.0),
            "correlation_time_s": (0.1, -1.0),
            "body_jerk_density_rad_s3_per_sqrt_hz": (30.0, 2.5),
        },
        "prior": {
            "velocity_std_m_s": (0.03, 1.0),
            "angle_rate_std_rad_s": (0.3, 1.0),
            "acceleration_std_m_s2": (0.3, 2.0),
            "angle_acceleration_std_rad_s2": (3.0, 2.0),
        },
    }
)
"""Part → quantity → (value at its own speed, exponent of the factor it is played at).

``process_noise`` drives tip and Euler angles of a pen without spin; ``free`` the tip and the
body of a free one: with this speed and time an axis of the tip has an acceleration of 0.3 m/s².
"""


def at_speed(part: str, speed: float = 1.0) -> dict[str, float]:
    """Return a part of `BY_SPEED` of a motion that is played at a factor of its own speed."""
    return {name: value * speed**exponent for name, (value, exponent) in BY_SPEED[part].items()}


def white_jerk_writing(speed: float = 1.0) -> Motion:
    """Return what drives a pen with Euler rates that writes."""
    levels = at_speed("process_noise", speed)
    return white_jerk_motion(
        levels["tip_jerk_density_m_s3_per_sqrt_hz"], levels["angle_jerk_density_rad_s3_per_sqrt_hz"]
    )


def bounded_writing(speed: float = 1.0) -> Motion:
    """Return what drives a free pen that writes: its tip does not get fast."""
    levels = at_speed("free", speed)
    jerk = levels.pop("body_jerk_density_rad_s3_per_sqrt_hz")
    return Motion(
        tip=TipBoundedVelocity(**levels),
        attitude=AttitudeWhiteJerk(jerk_density_rad_s3_per_sqrt_hz=jerk),
    )
