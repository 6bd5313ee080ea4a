"""What makes a window hard for a moving-horizon estimator: kinds of windows, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from models.motions import motions
from recordings.motion_list import DRAWN

TABLE = "table"
"""The turntable's motion at its constant rates."""


@dataclass(frozen=True)
class WindowKind:
    """What makes the windows of a kind.

    Parameters
    ----------
    label : for people
    motions : one of them is drawn for a pen; `DRAWN` follows the model's own noise
    table_motions : the same for a turntable
    speed : (slowest, fastest) factor that a pen's motion is played at
    before_s : (shortest, longest) time that the EKF runs before the window, s; none
        starts from the model's prior
    row_loss, sensor_loss, instant_loss : probabilities that a reading's row is missing,
        that a sensor is silent for a part of the window, that an instant has nothing
    slowest : a camera keeps one reading in 1 to this many
    wrong_rad : (least, most) distance of the prior's angles from where they were, rad
    drawn_guess : probability that the guess starts from a draw of the prior, not its mean
    """

    label: str
    motions: tuple[str, ...]
    table_motions: tuple[str, ...] = (TABLE, DRAWN)
    speed: tuple[float, float] = (1.0, 1.0)
    before_s: tuple[float, float] | None = (0.1, 1.2)
    row_loss: float = 0.0
    sensor_loss: float = 0.0
    instant_loss: float = 0.0
    slowest: int = 1
    wrong_rad: tuple[float, float] = (0.0, 0.0)
    drawn_guess: float = 0.0


SLOW_MOTIONS = tuple(motions())
KINDS: Mapping[str, WindowKind] = MappingProxyType(
    {
        "plain": WindowKind("plain", SLOW_MOTIONS),
        "missing": WindowKind(
            "missing rows",
            SLOW_MOTIONS,
            row_loss=0.15,
            sensor_loss=0.5,
            instant_loss=0.1,
            slowest=5,
        ),
        "fast": WindowKind(
            "fast motion",
            (*SLOW_MOTIONS, DRAWN),
            table_motions=(DRAWN,),
            speed=(3.0, 8.0),
            before_s=(0.05, 0.4),
        ),
        "bad start": WindowKind(
            "bad start",
            SLOW_MOTIONS,
            table_motions=(DRAWN,),
            before_s=None,
            wrong_rad=(0.5, 1.0),
            drawn_guess=0.5,
        ),
    }
)
"""Kinds of windows."""
