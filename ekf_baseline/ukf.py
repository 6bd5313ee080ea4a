"""The unscented Kalman filter on a model's manifold."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ekf_baseline.sigma_points import SigmaPoints
from ekf_baseline.state import check_late_samples, kept_for
from ekf_baseline.ukf_state import UkfState, gone_back
from ekf_baseline.unscented import Spread, root
from estimation.estimate import Estimate
from estimation.estimator import first_state, late_estimate, remarks
from estimation.exclusive import Exclusive, in_turn
from estimation.inputs import with_inputs
from estimation.intervals import check_step
from estimation.kalman_stage import rows_present, without_gaps
from estimation.recording import Measurement
from estimation.rest_detector import RestDetector
from estimation.result import check_rows
from estimation.settings import checked_config
from estimation.status import Status
from models.arrays import Array, is_real
from models.errors import InputError
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel


@dataclass(frozen=True, kw_only=True)
class UkfConfig:
    """Settings of the UKF; see `ekf_baseline.unscented`.

    Parameters
    ----------
    alpha : α, how far the points lie: α √(n + κ) standard deviations
    beta : β, what is known of the distribution beyond its covariance; 2 is right for a Gaussian
    kappa : κ, a second way to say how far
    late_samples : how many measurements back it takes a late one; see `ekf_baseline.ekf.EkfConfig`

    Raises
    ------
    InputError
        If α is not positive, κ or the number of measurements negative, or β less than α²: the
        covariance could then be indefinite.
    """

    alpha: float = 0.1
    beta: float = 2.0
    kappa: float = 0.0
    late_samples: int | None = None

    def __post_init__(self) -> None:
        if not (is_real(self.alpha) and 0 < self.alpha < np.inf):
            raise InputError(f"alpha is {self.alpha!r}, expected a positive number")
        if not (is_real(self.beta) and self.beta >= self.alpha**2):
            raise InputError(f"beta is {self.beta!r}, expected alpha² = {self.alpha**2:g} or more")
        if not (is_real(self.kappa) and self.kappa >= 0):
            raise InputError(f"kappa is {self.kappa!r}, expected 0 or more")
        check_late_samples(self.late_samples)


class Ukf(Exclusive):
    """Unscented Kalman filter on a state-space model.

    Noise takes part in the points (it may enter f in any way), and an update makes points anew.
    Behind an update the covariance belongs to the tangent space of the new mean: points of the
    posterior, as seen from there. Derivatives are used nowhere. It knows no gate, no loss and no
    bounds. A measurement older than the newest is taken at its own instant, as by the EKF: from
    the state before it on, all that followed is made again.

    References
    ----------
    Särkkä (2013), Bayesian Filtering and Smoothing, Algorithm 5.14 with noise in the points.
    The transform: see `ekf_baseline.unscented`.
    """

    name = "ukf"

    def __init__(self, model: StateSpaceModel, config: UkfConfig | None = None) -> None:
        self.model = model
        self.config = checked_config(self.name, config, UkfConfig)
        super().__init__(model, self.config)
        self._points, self._rest = SigmaPoints(model), RestDetector(model)
        self._kept = kept_for(model, self.config.late_samples).capacity
        told = self.config.alpha, self.config.beta, self.config.kappa
        self._step = Spread.of(model.n_x + model.n_w, *told)
        self._own = Spread.of(model.n_x, *told)

    def init(self, prior: Prior | None = None) -> UkfState:
        """Return the state before the first measurement; see `ekf_baseline.ekf.Ekf.init`."""
        first = first_state(self.model, prior)
        return UkfState(None, first, np.full(self.model.n_u, np.nan), self._rest.first())

    @in_turn
    def step(self, state: UkfState, measurement: Measurement) -> tuple[UkfState, Estimate]:
        """Predict to the measurement's time and update; one that is late changes what followed."""
        start, model, time_s = time.perf_counter(), self.model, measurement.time_s
        check_rows(model, np.asarray(time_s), measurement.y)
        if state.time_s is not None:
            check_step(model, *sorted((state.time_s, time_s)))
        taken: tuple[Measurement, ...] = (measurement,)
        if state.time_s is not None and time_s < state.time_s:
            found = gone_back(model, state, measurement)
            if found is None:
                return state, late_estimate(model, state.time_s, state.gaussian)
            state, taken = found
        state, estimate = self._advance(state, taken[0])
        for later in taken[1:]:
            state, newest = self._advance(state, later)
            estimate = replace(
                newest,
                status=(estimate.status | newest.status) & ~Status.NO_READING,
                innovation=estimate.innovation,
                innovation_covariance=estimate.innovation_covariance,
            )
        return state, replace(estimate, call_s=time.perf_counter() - start)

    @np.errstate(over="ignore", invalid="ignore")  # an absurd reading: the status says it
    def _advance(self, state: UkfState, measurement: Measurement) -> tuple[UkfState, Estimate]:
        """Take a measurement that is not older than the state."""
        model, time_s = self.model, measurement.time_s
        known = None if state.time_s is None else state.inputs
        y = with_inputs(model, known, measurement.y)
        inputs = y[model.n_y :]
        dt = 0.0 if state.time_s is None else time_s - state.time_s
        rest, y = self._rest.step(state.rest, dt, y)
        ends = (inputs if known is None else known, inputs) if model.n_u else ()
        predicted, status = self._predicted(state.gaussian, dt, ends), Status.SOLVED
        if not predicted.is_finite:
            predicted, status = state.gaussian, Status.NOT_FINITE  # the last rung
        present = rows_present(model, y)
        gaussian, v, S = self._updated(predicted, without_gaps(y), present)
        if not gaussian.is_finite:
            gaussian, status = predicted, Status.NOT_FINITE
        status |= remarks(model, gaussian, y, present)
        v = np.where(present, v, np.nan)
        past = (*state.past, (replace(state, past=()), measurement))[-self._kept :]
        after = UkfState(time_s, gaussian, inputs, rest, past if self._kept else ())
        return after, Estimate(time_s, gaussian, status, v, S)

    def _predicted(
        self, state: GaussianState, dt: float, inputs: tuple[Array, ...]
    ) -> GaussianState:
        """Return x⁻, P⁻ after `dt` seconds."""
        n_x, n_w = self.model.n_x, self.model.n_w
        both = np.zeros((n_x + n_w, n_x + n_w))
        both[:n_x, :n_x], both[n_x:, n_x:] = root(state.covariance), np.eye(n_w)
        points, spread = self._step.points(both), self._step
        reached, apart = self._points.reached(state.mean, points[:n_x], points[n_x:], dt, inputs)
        return self._around(reached, spread.mean(apart), spread.factors(apart))

    def _updated(
        self, state: GaussianState, y: Array, present: NDArray[np.bool_]
    ) -> tuple[GaussianState, Array, Array]:
        """Return x⁺, P⁺, the innovation v (n_r,) and its covariance S (n_r, n_r)."""
        spread, noise_std = self._own, self.model.noise_std
        points = spread.points(root(state.covariance))
        central, apart = self._points.read(state.mean, points, y)
        there = present[:, None]
        factors = np.where(there, spread.factors(apart), 0.0)
        v = np.where(present, central + spread.mean(apart), 0.0)
        wide = np.hstack([factors, np.diag(noise_std)])
        S = wide @ wide.T
        C = spread.weight * points @ np.where(there, apart, 0.0).T
        if not np.isfinite(S).all():
            return replace(state, mean=np.full_like(state.mean, np.nan)), v, S
        T: Array = np.asarray(np.linalg.qr(wide.T, mode="r"))  # S = Tᵀ T
        K = -np.linalg.solve(T, np.linalg.solve(T.T, C.T)).T  # a residual is y less h
        own = np.column_stack([np.sqrt(spread.weight) * points, np.zeros(len(points))])
        return self._around(state.mean, K @ v, np.hstack([own + K @ factors, K * noise_std])), v, S

    def _around(self, x: Array, delta: Array, factors: Array) -> GaussianState:
        """Return x ⊞ δ with the covariance A Aᵀ of x's tangent space taken to it."""
        found = GaussianState(self._points.retract(x, delta), factors @ factors.T)
        if not found.is_finite:
            return found
        points = self._own.points(root(found.covariance))
        apart = self._points.seen_from(found.mean, x, delta[:, None] + points)
        moved = np.sqrt(self._own.weight) * apart
        return GaussianState(found.mean, moved @ moved.T)
