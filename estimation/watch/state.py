"""What a watch knows between two steps: a value, as is the state of what it watches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimation.watch.past import Past
from models.arrays import Array
from models.gaussian import GaussianState

RETRY_S = 1.0
"""So long a sensor is left out before it is first tried again."""


@dataclass(frozen=True)
class LeftOut:
    """A sensor that is left out.

    Parameters
    ----------
    retry_s : when it is tried again
    tries : how often it was
    """

    sensor: int
    retry_s: float
    tries: int = 0


@dataclass(frozen=True, eq=False)
class WatchState:
    """A watch after its last measurement.

    Parameters
    ----------
    inner : the state of the estimator that is watched
    level : of that estimator, see `estimation.watch.livelier`
    prior : what it was begun with
    memory : of the statistics
    past : what an alarm goes back over
    out : sensors that are left out
    known : (n_x,) components that were known once, see `estimation.watch.reach`
    std : (n_x,) of the newest estimate
    is_lost : whether one of those is not known
    is_unexplained : whether an alarm has found no cause
    time_s : of the newest instant; None before the first
    calm_s : until when nothing is judged
    quiet_s : until when no alarm is followed
    alarm_s : when an alarm is followed that waits; inf where none does
    freed_s, doubted_s : (n_sensors,) when a bias was freed, until when a sensor is spoken of
    blamed : (n_sensors,) when each was last left out, and how long at least
    level_s : since when the level is what it is
    pending : `estimation.watch.in_time.Pending`, None where nothing waits for time
    """

    inner: Any
    prior: GaussianState
    memory: Array
    past: Past
    known: NDArray[np.bool_]
    std: Array
    freed_s: Array
    doubted_s: Array
    blamed: tuple[tuple[float, float], ...]
    level: int = 0
    out: tuple[LeftOut, ...] = ()
    is_lost: bool = False
    is_unexplained: bool = False
    time_s: float | None = None
    calm_s: float = -np.inf
    quiet_s: float = -np.inf
    alarm_s: float = np.inf
    level_s: float = -np.inf
    pending: Any = None

    @property
    def left_out(self) -> frozenset[int]:
        """Numbers of the sensors that are left out."""
        return frozenset(each.sensor for each in self.out)

    @property
    def spoken_s(self) -> float:
        """Until when some sensor is spoken of."""
        return max(self.doubted_s.tolist())
