"""The windows that every contender of a problem is given.

An EKF runs over the problem's recording, without bounds, and leaves a prior x_k|k-1 at every
stage. From there a moving horizon slides by one stage: the window before, which has the EKF's
prior, is solved by the reference, with bounds where the problem has them. The window is
then the prior that the default arrival cost carries on, N + 1 measurements, and as warm start
the solution, shifted, its newest stage predicted.

Angles run on through ±π instead of being wrapped, so that a contender may add and
subtract states as plain vectors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from estimation.kalman_stage import KalmanStage, rows_present, without_gaps
from estimation.recording import Measurement
from mhe.arrival_cost import ARRIVAL_COSTS, Slide
from mhe.config import MheIpoptConfig, WindowConfig
from mhe.reference.ipopt import MheIpopt
from mhe.trajectory import Trajectory, WindowSolution
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from suites.speed.problems import DURATION_S, Problem
from suites.speed.tangent import is_plain

SETTLED = 50
"""Stages before the first window: the prior has forgotten where it began."""
STRIDE = 3
"""Stages from one window to the next."""
TOLERANCE = 1e-10
"""Of the reference, in standard deviations. IPOPT gets there; 1e-12 is below its rounding."""


@dataclass(frozen=True, eq=False)
class PreviousWindow:
    """A window that was solved: its prior, its N + 1 measurements, and its optimum."""

    prior: GaussianState
    measurements: tuple[Measurement, ...]
    trajectory: Trajectory


@dataclass(frozen=True, eq=False)
class SpeedWindow:
    """One window of a problem.

    Parameters
    ----------
    model : its model
    prior : of the first stage, given all measurements before it
    measurements : N + 1 stages
    guess : the warm start
    scale : (n_x,) standard deviations of the newest state, by a pass at the warm start:
        what a solver may measure states in
    previous : the window one stage earlier, for an estimator that slides on by itself
    """

    model: StateSpaceModel
    prior: GaussianState
    measurements: tuple[Measurement, ...]
    guess: Trajectory
    scale: Array
    previous: PreviousWindow

    @cached_property
    def prior_factor(self) -> Array:
        """(n_x, n_x) lower triangle L̄, L̄ L̄ᵀ = P̄."""
        return np.asarray(np.linalg.cholesky(self.prior.covariance), dtype=float)

    @cached_property
    def prior_factor_inverse(self) -> Array:
        """(n_x, n_x) lower triangle L̄⁻¹."""
        identity = np.eye(self.model.n_x)
        return np.asarray(solve_triangular(self.prior_factor, identity, lower=True), dtype=float)

    @cached_property
    def dt(self) -> Array:
        """(N,) intervals, s."""
        return np.diff([measurement.time_s for measurement in self.measurements])

    @cached_property
    def y(self) -> Array:
        """(N + 1, n_y) readings, zero where there is none."""
        return np.array([without_gaps(measurement.y) for measurement in self.measurements])

    @cached_property
    def present(self) -> NDArray[np.bool_]:
        """(N + 1, n_r) rows of the residual that have a reading."""
        return np.array([rows_present(self.model, m.y) for m in self.measurements])


@dataclass(frozen=True, eq=False)
class SolvedWindow:
    """A window with the reference's solution of it."""

    window: SpeedWindow
    optimum: WindowSolution


def solved_windows(problem: Problem, count: int) -> list[SolvedWindow]:
    """Return the first windows of a problem's table, with their optima.

    Parameters
    ----------
    count : at least 1; a longer table begins with the shorter one
    """
    model, n_stages = problem.model, problem.horizon + 1
    stage = KalmanStage(model)
    reference = MheIpopt(model, MheIpoptConfig(horizon=problem.horizon, tolerance=TOLERANCE))
    first = SETTLED + STRIDE * np.arange(count)
    measurements = recorded(problem, model, int(first[-1]) + n_stages)
    priors, means = _filtered(stage, measurements)

    def solved(k: int) -> SolvedWindow:
        before, now = slice(k - 1, k - 1 + n_stages), slice(k, k + n_stages)
        unshaken = Trajectory(means[before], np.zeros((problem.horizon, model.n_w)))
        older, stages = tuple(measurements[before]), tuple(measurements[now])
        found = reference.solve(priors[k - 1], older, unshaken).trajectory
        prior = _carried(stage, priors[k - 1], older, found)
        guess = running_on(model, prior.mean, _shifted(model, found, stages[-2:]))
        scale = _newest_std(stage, prior, stages, guess)
        previous = PreviousWindow(priors[k - 1], older, found)
        window = SpeedWindow(model, prior, stages, guess, scale, previous)
        return SolvedWindow(window, reference.solve(window.prior, stages, guess))

    return [solved(int(k)) for k in first]


def running_on(model: StateSpaceModel, start: Array, trajectory: Trajectory) -> Trajectory:
    """Return the same trajectory with angles that run on from a state, without a wrap."""
    if not is_plain(model):  # has no angles that could
        return trajectory
    path, before = [], start
    for state in trajectory.states:
        before = before + np.asarray(model.difference(state, before)).ravel()
        path.append(before)
    return Trajectory(np.array(path), trajectory.noises)


def recorded(problem: Problem, model: StateSpaceModel, count: int) -> list[Measurement]:
    """Return the first stages of the problem's recording.

    Raises
    ------
    InputError
        If it has not so many.
    """
    recording = problem.body.record(DURATION_S, problem.seed)
    if count > len(recording.time_s):
        raise InputError(
            f"problem {problem.key} asks for {count} stages of a recording, "
            f"expected at most {len(recording.time_s)}"
        )
    return list(recording.measurements(model))[:count]


def _filtered(
    stage: KalmanStage, measurements: Sequence[Measurement]
) -> tuple[list[GaussianState], Array]:
    """Return an EKF's x_k|k-1 and its means of x_k|k (n, n_x)."""
    priors, means, posterior = [stage.model.prior], [], stage.model.prior
    for k, measurement in enumerate(measurements):
        if k:
            dt = measurement.time_s - measurements[k - 1].time_s
            priors.append(stage.predict(posterior, dt).state)
        posterior = stage.update(priors[-1], measurement.y).state
        means.append(posterior.mean)
    return priors, np.array(means)


def _carried(
    stage: KalmanStage,
    prior: GaussianState,
    measurements: Sequence[Measurement],
    trajectory: Trajectory,
) -> GaussianState:
    """Return the prior of the window behind a solved one, by the default arrival cost."""
    dropped, first = measurements[:2]
    rows = rows_present(stage.model, dropped.y).astype(float)
    unread = trajectory.states[1]  # x_k|k-1 of that stage: another arrival cost wants it
    slide = Slide(prior, dropped, first, trajectory, unread, rows, np.ones(stage.model.n_w))
    return ARRIVAL_COSTS[WindowConfig().arrival_cost](stage, slide)


def _newest_std(
    stage: KalmanStage,
    prior: GaussianState,
    stages: Sequence[Measurement],
    guess: Trajectory,
) -> Array:
    """Return the standard deviations (n_x,) of the newest state, linearised at a trajectory."""
    gaussian = stage.update(prior, stages[0].y, x_lin=guess.states[0]).state
    for k, w in enumerate(guess.noises):
        dt = stages[k + 1].time_s - stages[k].time_s
        gaussian = stage.predict(gaussian, dt, guess.states[k], w).state
        gaussian = stage.update(gaussian, stages[k + 1].y, x_lin=guess.states[k + 1]).state
    return gaussian.std


def _shifted(
    model: StateSpaceModel, previous: Trajectory, newest_two: Sequence[Measurement]
) -> Trajectory:
    """Drop the oldest stage of a solution and predict a newest one."""
    no_noise = np.zeros(model.n_w)
    dt = newest_two[1].time_s - newest_two[0].time_s
    newest = np.asarray(model.f(previous.states[-1], no_noise, dt)).ravel()
    return Trajectory(
        np.vstack([previous.states[1:], newest]), np.vstack([previous.noises[1:], no_noise])
    )
