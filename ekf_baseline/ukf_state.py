"""The unscented filter's state, and where a late measurement finds its place in it."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, replace

import numpy as np

from ekf_baseline.log import joined, may_join
from estimation.recording import Measurement
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class UkfState:
    """The filter after its last measurement.

    Parameters
    ----------
    time_s : of it; None before the first
    gaussian : x_k|k, or the prior x_0|-1
    inputs : (n_u,) the last known ones
    rest : what the detector of rest remembers
    past : measurements that it can go back by, each with the state before it; the oldest first
    """

    time_s: float | None
    gaussian: GaussianState
    inputs: Array
    rest: Array
    past: tuple[tuple[UkfState, Measurement], ...] = ()


def gone_back(
    model: StateSpaceModel, state: UkfState, late: Measurement
) -> tuple[UkfState, tuple[Measurement, ...]] | None:
    """Return the state before a late measurement, and all that is to be taken from there on.

    Readings join those of the same instant, where it had none of them, as they do in an EKF.

    Returns
    -------
    None where it is older than what is kept.
    """
    times = [measurement.time_s for _, measurement in state.past]
    first, at = bisect_left(times, late.time_s), bisect_right(times, late.time_s)
    for k in reversed(range(first, at)):
        there = state.past[k][1]
        if may_join(model, there.y, late.y):
            both = replace(there, y=joined(there.y, late.y))
            return _from(state, k, both, k + 1)
    is_known = at > 0 or (
        len(times) > 0
        and state.past[0][0].time_s is None
        and bool(np.isfinite(late.y[model.n_y :]).all())
    )
    return _from(state, at, late, at) if is_known else None


def _from(
    state: UkfState, place: int, taken: Measurement, following: int
) -> tuple[UkfState, tuple[Measurement, ...]]:
    before = replace(state.past[place][0], past=state.past[:place])
    return before, (taken, *(measurement for _, measurement in state.past[following:]))
