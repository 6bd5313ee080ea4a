"""A trajectory over a window, and what a solver makes of one window."""

from __future__ import annotations

from dataclasses import dataclass

from estimation.status import Status
from models.arrays import Array
from models.gaussian import GaussianState


@dataclass(frozen=True, eq=False)
class Trajectory:
    """States (n+1, n_x) and unit process noises (n, n_w) over a window."""

    states: Array
    noises: Array


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
