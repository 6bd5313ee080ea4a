"""Late measurements: where they go in a window, and what the window has there.

A measurement's time is that of its capture. One that arrives when newer ones are there is taken at
its capture, as long as the window reaches back to it: to its oldest stage, and as long as the
window has room also to before that, under the same prior. Where a stage of the very same time has
none of its readings they join that stage; else it becomes a stage of its own between two others (at
the same time behind the one that is there), and the oldest goes where the window is full. Stages in
front of it keep their linearisation points and factors; from it on one pass makes them anew. The
first readings of a sensor, where they are late, get passes until the step is short: in time they
would have had a pass with each sample since, and one from the prior alone was up to five standard
deviations off.

Its state is led to from the stage before by its share of the noise w that led over the whole step:

    w_1 = sqrt(Δt_1 / Δt) w,   w_2 = sqrt(Δt_2 / Δt) w

The state behind does not follow from it then: the pass closes that defect, exactly on a linear
model. ``mhe`` takes its first step whatever a start that does not follow costs. Rolled out from
the late stage on it would be a trajectory, but one that leaves the solution before.

mhe/compiled/late.c is the same in C.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.state_space import StateSpaceModel


@dataclass(frozen=True)
class StagePlace:
    """Where a measurement goes.

    Parameters
    ----------
    at : its stage in the window to come; below 0 where that is out of reach
    drop : how many of the oldest stages go
    is_late : whether newer measurements are there
    joins : whether it joins a stage that is there
    """

    at: int
    drop: int
    is_late: bool
    joins: bool

    @property
    def behind(self) -> int:
        """The first stage behind it, in the window before."""
        return self.at + self.drop

    @property
    def before(self) -> int:
        """The stage whose inputs it has where its own are missing, in the window before."""
        return max(self.at if self.joins else self.behind - 1, 0)


ALONE = StagePlace(0, 0, is_late=False, joins=False)
"""Of the first measurement of a window."""


def place_of(
    times: Sequence[float] | Array,
    there: Sequence[NDArray[np.bool_]],
    capacity: int,
    time_s: float,
    y: Array,
) -> StagePlace:
    """Return where a measurement goes.

    Parameters
    ----------
    times : (n,) of the window's stages
    there : per stage (n_y,), which readings it has, see `readings_there`
    capacity : most stages
    y : (n_row,) of the measurement
    """
    n = len(times)
    at, drop = int(np.searchsorted(times, time_s, side="right")), int(n == capacity)
    for k in reversed(range(at if at < n else 0)):
        if times[k] != time_s:
            break
        if not (np.isfinite(y[: len(there[k])]) & there[k]).any():
            return StagePlace(k, 0, is_late=True, joins=True)
    return StagePlace(at - drop, drop, is_late=at < n, joins=False)


def readings_there(model: StateSpaceModel, present: Array | NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which readings (n_y,) a stage has: one that no row present needs counts as missing."""
    needed: NDArray[np.bool_] = np.any(model.row_needs[present > 0], axis=0)
    return needed


def sensors_there(model: StateSpaceModel, rows: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which sensors (n_sensors,) measured some of the rows (n_r,) of the residual."""
    ends = np.cumsum([sensor.n_r for sensor in model.sensors])[:-1]
    return np.array([part.any() for part in np.split(rows & model.measured_rows, ends)])


def joined(stage: Array, y: Array) -> Array:
    """Return the row (n_row,) of a stage whose missing readings are those of another row."""
    return np.where(np.isfinite(y), y, stage)


def shares(times: Sequence[float] | Array, behind: int, time_s: float) -> tuple[float, float]:
    """Return by what both noises around a late stage are the one that led over the whole step.

    Parameters
    ----------
    behind : the stage that it stands in front of, not the first
    """
    dt = times[behind] - times[behind - 1]
    part = (time_s - times[behind - 1]) / dt
    return float(np.sqrt(part)), float(np.sqrt(1 - part))
