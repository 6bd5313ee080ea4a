"""The optimum is a fixed point of the Kalman stage: a Gauss-Newton step goes nowhere."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from mhe.reference.state import MheState
from models.arrays import Array
from models.gaussian import GaussianState
from tests.estimation import pens
from tests.references.batch import white_jerk_step


def forward_pass(
    stage: KalmanStage,
    prior: GaussianState,
    measurements: tuple[Measurement, ...],
    states: Array,
    noises: Array,
) -> GaussianState:
    gaussian = stage.update(prior, measurements[0].y, x_lin=states[0]).state
    for k, w in enumerate(noises):
        dt = measurements[k + 1].time_s - measurements[k].time_s
        predicted = stage.predict(gaussian, dt, x_lin=states[k], w_lin=w).state
        gaussian = stage.update(predicted, measurements[k + 1].y, x_lin=states[k + 1]).state
    return gaussian


def noises_between(states: Array, measurements: tuple[Measurement, ...]) -> Array:
    noises = []
    for k, dt in enumerate(np.diff([m.time_s for m in measurements])):
        F, G = white_jerk_step(float(dt), pens.DENSITIES)
        noises.append(np.linalg.solve(G, states[k + 1] - F @ states[k]))
    return np.array(noises)


@pytest.mark.parametrize("horizon", [6, 15])
def test_newest_state_comes_back(horizon: int) -> None:
    """With a horizon of 6 the window has slid over a filtered arrival cost."""
    run = pens.draw_pen_run(16, seed=1)
    mhe = MheIpopt(run.model, MheIpoptConfig(horizon=horizon))
    stage, state = KalmanStage(run.model), mhe.init()
    for measurement in run.measurements:
        state, estimate = mhe.step(state, measurement)
    states = estimate.window.states  # type: ignore[union-attr]
    assert isinstance(state, MheState)
    noises = noises_between(states, state.measurements)
    back = forward_pass(stage, state.prior, state.measurements, states, noises)
    assert np.abs((back.mean - states[-1]) / back.std).max() < 1e-6
    std = back.std
    error_P = (back.covariance - estimate.state.covariance) / np.outer(std, std)
    assert np.abs(error_P).max() < 1e-6


def test_away_from_the_optimum_it_does_not_come_back() -> None:
    """The check above has teeth: half a standard deviation aside, the pass moves."""
    run = pens.draw_pen_run(16, seed=1)
    mhe = MheIpopt(run.model, MheIpoptConfig(horizon=15))
    stage, state = KalmanStage(run.model), mhe.init()
    for measurement in run.measurements:
        state, estimate = mhe.step(state, measurement)
    states = estimate.window.states.copy()  # type: ignore[union-attr]
    states[-1] += 0.5 * estimate.state.std
    noises = noises_between(states, state.measurements)
    back = forward_pass(stage, state.prior, state.measurements, states, noises)
    assert np.abs((back.mean - states[-1]) / back.std).max() > 0.1
