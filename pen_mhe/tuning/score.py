"""What a judge of noise levels is given, and what it says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from estimation.estimate import EstimateHistory
from models.arrays import Array
from models.pen_config import PenConfig

NATS = 2.0
"""A loss of likelihood that is as good as none: two standard deviations of a number."""


class Filter(Protocol):
    """Runs the EKF of a pen; `pen_mhe.tuning.levels.LevelFilter.history`."""

    def __call__(
        self, pen: PenConfig, time_s: Array, y: Array, *, covariances: bool = False
    ) -> EstimateHistory:
        """Return what it says of stacked readings."""


@dataclass(frozen=True)
class Score:
    """Of one pen on one part of a recording.

    Parameters
    ----------
    value : smaller is better, in the objective's unit; inf where the filter broke down
    figures : name with its unit → number, for people
    loss : how much worse is as good, as chance decides
    """

    value: float
    figures: Mapping[str, float]
    loss: float


Judge = Callable[[Filter, PenConfig], Score]
"""Of a part of a recording."""
