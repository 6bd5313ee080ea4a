"""What stands in a real-time estimator's window, before and after a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from estimation.estimate import Estimate
from estimation.recording import Measurement
from mhe.config import RealTimeConfig
from mhe.realtime import Mhe, MheRti
from mhe.trajectory import Trajectory
from mhe.window_memory import View, WindowState, window_memory
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class Moved:
    """One step: the window that it solved, the guess it started from, and where it ended.

    Parameters
    ----------
    before, after : windows before and after the step
    measurements : of the window that was solved
    prior : of its first stage
    guess : the last solution shifted, with one stage predicted
    found : states and noises after the step
    estimate : of the step
    """

    before: View
    after: View
    measurements: tuple[Measurement, ...]
    prior: GaussianState
    guess: Trajectory
    found: Trajectory
    estimate: Estimate


def real_time(estimator: str, model: StateSpaceModel, config: RealTimeConfig) -> Mhe | MheRti:
    """Return `mhe-rti` or `mhe`."""
    kinds: dict[str, Any] = {kind.name: kind for kind in (MheRti, Mhe)}
    found: Mhe | MheRti = kinds[estimator](model, config)
    return found


def window_of(mhe: Mhe | MheRti, state: WindowState) -> View:
    """Look at a window."""
    return View.of(window_memory(mhe.model, mhe.config.horizon + 1), state.memory)


def moves(mhe: Mhe | MheRti, measurements: list[Measurement]) -> list[Moved]:
    """Step through measurements that are all on time."""
    state, found = mhe.init(), []
    for k, measurement in enumerate(measurements):
        before = window_of(mhe, state)
        state, estimate = mhe.step(state, measurement)
        after = window_of(mhe, state)
        n = len(after.times)
        window = tuple(measurements[k + 1 - n : k + 1])
        x = mhe.model.prior.mean[None]
        w = np.zeros((0, mhe.model.n_w))
        if k:
            dt, no_noise = measurement.time_s - before.times[-1], np.zeros(mhe.model.n_w)
            predicted = np.asarray(mhe.model.f(before.x[-1], no_noise, dt)).ravel()
            x, w = np.vstack([before.x, predicted])[-n:], np.vstack([before.w, no_noise])[1 - n :]
        guess = Trajectory(x, w)
        solved = Trajectory(after.x, after.w)
        found.append(Moved(before, after, window, after.prior, guess, solved, estimate))
    return found
