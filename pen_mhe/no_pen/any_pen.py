"""The pen by which a recording is read of which no pen is known: one sensor of each kind."""

from __future__ import annotations

from functools import cache

from models.pen_config import PenConfig
from models.pen_file import parse_pen

ACCEL, GYRO, CAMERA = "accel", "gyro", "camera"
"""Names of its sensors, and of those of a pen that is found."""


@cache
def any_pen() -> PenConfig:
    """Return it; its noises are a data sheet's, only to tell rest from motion."""
    return parse_pen(
        {
            "name": "any pen",
            "sensors": {
                # With a bias, so that the truth of one may stand in the recording.
                ACCEL: {
                    "preset": "LSM6DS3-accelerometer",
                    "range_m_s2": None,
                    "bias_std_mg": 20.0,
                },
                GYRO: {
                    "preset": "LSM6DS3-gyroscope",
                    "range_rad_s": None,
                    "bias_std_deg_s": 1.0,
                },
                CAMERA: {
                    "kind": "pose_camera",
                    "position_std_mm": 1.0,
                    "orientation_std_deg": 1.0,
                },
            },
        }
    )
