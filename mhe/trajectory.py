"""A trajectory over a window, and what a solver makes of one window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from estimation.recording import Measurement
from estimation.status import Status
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class Trajectory:
    """States (n+1, n_x) and unit process noises (n, n_w) over a window."""

    states: Array
    noises: Array


def driven(
    model: StateSpaceModel, x_0: Array, noises: Array, measurements: Sequence[Measurement]
) -> Trajectory:
    """Return the trajectory from a first state (n_x,), driven by noises (n, n_w).

    Parameters
    ----------
    measurements : (n+1) of a window, with all inputs, see `estimation.inputs.all_with_inputs`
    """
    states = [x_0]
    for w, (last, here) in zip(noises, pairwise(measurements), strict=True):
        step = here.time_s - last.time_s, *model.step_inputs(last.y, here.y)
        states.append(np.asarray(model.f(states[-1], w, *step)).ravel())
    return Trajectory(np.array(states), noises)


@dataclass(frozen=True, eq=False)
class WindowSolution:
    """What a solver makes of one window.

    Parameters
    ----------
    trajectory : states and noises
    newest : the newest state with its Gauss-Newton covariance
    cost : ½ the sum of squares, prior and noises included
    status, iterations : of the solver
    """

    trajectory: Trajectory
    newest: GaussianState
    cost: float
    status: Status
    iterations: int
