"""How a hand that writes gently moves, and at what speed: numbers for pen files."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

BY_SPEED: Mapping[str, Mapping[str, tuple[float, float]]] = MappingProxyType(
    {
        "process_noise": {
            "tip_jerk_density_m_s3_per_sqrt_hz": (2.0, 2.5),
            "angle_jerk_density_rad_s3_per_sqrt_hz": (20.0, 2.5),
        },
        "prior": {
            "velocity_std_m_s": (0.03, 1.0),
            "angle_rate_std_rad_s": (0.3, 1.0),
            "acceleration_std_m_s2": (0.3, 2.0),
            "angle_acceleration_std_rad_s2": (3.0, 2.0),
        },
    }
)
"""How the motion moves: (value at its own speed, exponent of the factor it is played at).

RMS of its derivatives; RMS jerk over the square root of its bandwidth. Played s
times faster, jerk grows by s³ and bandwidth by s.
"""
