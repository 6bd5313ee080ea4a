"""A transition that is nonlinear in state and noise: derivatives, arrival cost, optimum, limits."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.kalman_stage import KalmanStage
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from models.gaussian import GaussianState
from tests.mhe import pendulum
from tests.mhe.pendulum import PendulumBatch


@pytest.fixture(scope="module")
def stage() -> KalmanStage:
    return KalmanStage(pendulum.model())


def test_prediction_is_linearised_at_the_point_given(stage: KalmanStage) -> None:
    rng, dt = np.random.default_rng(1), 0.06
    for _ in range(5):
        x_lin, w_lin, x = rng.standard_normal((3, 2))
        root = np.tril(rng.standard_normal((2, 2))) + 2 * np.eye(2)
        P = root @ root.T
        F, G = pendulum.derivatives(x_lin, w_lin, dt)
        predicted = stage.predict(GaussianState(x, P), dt, x_lin=x_lin, w_lin=w_lin).state
        wanted = pendulum.step(x_lin, w_lin, dt) + F @ (x - x_lin) - G @ w_lin
        np.testing.assert_allclose(predicted.mean, wanted, rtol=0, atol=1e-12)
        wanted_P = F @ P @ F.T + G @ G.T
        np.testing.assert_allclose(predicted.covariance, wanted_P, rtol=0, atol=1e-12)


@pytest.mark.parametrize("arrival_cost", ["filtered", "smoothed"])
def test_an_arrival_cost_eliminates_the_dropped_stage(arrival_cost: str) -> None:
    """At the filter's mean, or at the window's trajectory."""
    measurements, slides = pendulum.simulate(60, seed=2), 0
    mhe = MheIpopt(pendulum.model(), MheIpoptConfig(horizon=4, arrival_cost=arrival_cost))
    state = mhe.init()
    for measurement in measurements:
        before, (state, _) = state, mhe.step(state, measurement)
        if len(before.measurements) < 5:
            continue
        assert state.measurements[0] is before.measurements[1]
        assert before.trajectory is not None
        x, w = before.trajectory.states[0], before.trajectory.noises[0]
        dropped, mean = before.measurements[0], before.prior.mean
        dt = before.measurements[1].time_s - dropped.time_s
        at = {"smoothed": (x, w), "filtered": (mean, None)}
        wanted = pendulum.eliminate(before.prior, dropped, dt, *at[arrival_cost])
        slides += 1
        assert np.abs((state.prior.mean - wanted.mean) / wanted.std).max() < 1e-10
        error_P = state.prior.covariance - wanted.covariance
        assert np.abs(error_P / np.outer(wanted.std, wanted.std)).max() < 1e-10
    assert slides == 55


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_full_window_is_the_least_squares_optimum(seed: int) -> None:
    """SciPy starts from the MHE's point: it must stay, and the gradient there must vanish."""
    measurements = pendulum.simulate(12, seed)
    mhe = MheIpopt(pendulum.model(), MheIpoptConfig(horizon=11))
    state = mhe.init()
    for measurement in measurements:
        state, estimate = mhe.step(state, measurement)
        assert estimate.status.is_solved
    assert estimate.window is not None
    batch = PendulumBatch(measurements)
    wanted, std = batch.solve(batch.noises(estimate.window.states))
    assert np.abs((estimate.window.states - wanted) / std).max() < 1e-6
    assert np.abs(estimate.state.std / std[-1] - 1).max() < 1e-6


@pytest.mark.parametrize("max_iterations", [1, 2, 3])
def test_an_unfinished_window_is_never_worse_than_its_start(max_iterations: int) -> None:
    """Here IPOPT's iterates leave the dynamics: rolled out they can cost more than the start."""
    for seed in range(8):
        measurements = pendulum.simulate(12, seed)
        mhe = MheIpopt(pendulum.model(), MheIpoptConfig(horizon=11, max_iterations=max_iterations))
        state, start = mhe.init(), np.zeros(2)
        for k, measurement in enumerate(measurements):
            state, estimate = mhe.step(state, measurement)
            assert estimate.window is not None
            assert state.trajectory is not None
            batch = PendulumBatch(measurements[: k + 1])
            z = batch.noises(estimate.window.states)
            assert batch.cost(z) <= batch.cost(start) * (1 + 1e-9) + 1e-9
            np.testing.assert_allclose(state.trajectory.noises.ravel(), z[2:], rtol=0, atol=1e-6)
            start = np.concatenate([z, np.zeros(2)])
