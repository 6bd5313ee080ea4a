"""A pen whose truth may be drawn from its model for minutes: all that it does stays bounded."""

from __future__ import annotations

import tomllib

from models.bundled import bundled_pens
from models.pen_config import PenConfig
from models.pen_file import parse_pen

ATTITUDE = {"chain": "bounded_velocity", "rate_rad_s": 1.5, "correlation_time_s": 0.15}


def bounded_pen(**top: object) -> PenConfig:
    """Return the D-POINT pen in a hand that does not turn faster and faster."""
    data = tomllib.loads(bundled_pens()["dpoint"].read_text("utf-8"))
    data["motion"]["attitude"] = ATTITUDE
    return parse_pen({**data, **top})
