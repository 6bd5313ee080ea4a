"""The cases of the suite as data: how the carrier turns, and what its installation is like."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from suites.tilt.turns import Tilting, Turn


@dataclass(frozen=True)
class Installation:
    """How the sensors of `models/turntables/tilt_tracker.toml` do in one place.

    Parameters
    ----------
    accelerometer_noise, gyroscope_noise : factors to the noise; the models are told
    gyroscope_bias_deg_s : of both axes, the same in every recording. The models are told
        that there may be one of this size, and estimate it
    """

    accelerometer_noise: float = 1.0
    gyroscope_noise: float = 1.0
    gyroscope_bias_deg_s: float = 0.0


@dataclass(frozen=True)
class TiltCase:
    """A motion in an installation.

    Parameters
    ----------
    turn, installation : which
    weighed_by : the error by which weights are chosen: as published the angle that turns,
        where it turns about one level axis; else the direction, of which the recursion can
        lose what the angle does not show
    """

    turn: Turn
    installation: Installation = Installation()
    weighed_by: Literal["roll", "direction"] = "roll"


_ONCE_AROUND = Turn(theta=Tilting(turn_deg=360.0))
_SWING = Tilting(swing_deg=45.0)
FULL_TURN, TWO_AXES = "full turn", "swing, two axes"
CASES: Mapping[str, TiltCase] = MappingProxyType(
    {
        FULL_TURN: TiltCase(_ONCE_AROUND),
        "full turn, fast": TiltCase(Turn(theta=Tilting(turn_deg=360.0), moving_s=4.0)),
        "full turn, slow": TiltCase(Turn(theta=Tilting(turn_deg=360.0), moving_s=30.0)),
        "full turn, shaken": TiltCase(_ONCE_AROUND, Installation(accelerometer_noise=5.0)),
        "full turn, poor gyroscope": TiltCase(_ONCE_AROUND, Installation(gyroscope_noise=10.0)),
        "full turn, biased gyroscope": TiltCase(
            _ONCE_AROUND, Installation(gyroscope_bias_deg_s=1.0)
        ),
        "full turn, two axes": TiltCase(
            Turn(Tilting(swing_deg=45.0, swings=1.0), Tilting(turn_deg=360.0)),
            weighed_by="direction",
        ),
        "swing, one axis": TiltCase(Turn(theta=_SWING)),
        TWO_AXES: TiltCase(
            Turn(Tilting(swing_deg=45.0, phase=0.25), _SWING), weighed_by="direction"
        ),
        "swing, leaning": TiltCase(Turn(Tilting(start_deg=30.0), _SWING), weighed_by="direction"),
        "rest": TiltCase(
            Turn(Tilting(start_deg=20.0), Tilting(start_deg=30.0)), weighed_by="direction"
        ),
    }
)
"""Name → case. What turns once around is θ: the other tilt has a horizon at 90 degrees."""

CURVE_CASES = (
    FULL_TURN,
    "full turn, shaken",
    "full turn, poor gyroscope",
    "full turn, biased gyroscope",
    TWO_AXES,
    "swing, leaning",
)
"""Cases whose error is shown over the weight."""
