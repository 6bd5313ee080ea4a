"""Limits, constraints that cannot be met, late and empty measurements: failure is data."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from mhe.reference.state import MheState
from models.arrays import Array
from tests.configs import config_for
from tests.estimation import pens
from tests.linear_models import constant_acceleration_system, coupled_system, irregular_times
from tests.mhe.runs import ESTIMATORS
from tests.references.batch import white_jerk_step

RUN = pens.draw_pen_run(14, seed=4)


def is_finite(estimate: Estimate) -> bool:
    assert estimate.window is not None
    arrays = (estimate.state.mean, estimate.state.covariance, estimate.window.states)
    return all(np.isfinite(array).all() for array in arrays)


def warm_start(before: Estimate | None, state: MheState) -> Array:
    """The last window's states that are still in this one, and a prediction without noise."""
    if before is None or before.window is None:
        return state.prior.mean[None, :]
    kept = np.isin(before.window.time_s, [m.time_s for m in state.measurements])
    dt = state.measurements[-1].time_s - before.time_s
    F, _ = white_jerk_step(dt, pens.DENSITIES)
    return np.vstack([before.window.states[kept], F @ before.window.states[-1]])


@pytest.mark.cover
@pytest.mark.parametrize("horizon", [4, 13])
@pytest.mark.parametrize(
    ("settings", "flag"),
    [
        ({"max_iterations": 0}, Status.ITERATION_LIMIT),
        ({"max_iterations": 1}, Status.ITERATION_LIMIT),
        ({"max_iterations": 3}, Status.ITERATION_LIMIT),
        ({"deadline_s": 1e-6}, Status.TIME_LIMIT),
    ],
)
def test_a_limit_returns_the_best_point(
    horizon: int, settings: dict[str, Any], flag: Status
) -> None:
    """Never worse than the warm start, by a cost written down without CasADi."""
    mhe = MheIpopt(RUN.model, MheIpoptConfig(horizon=horizon, **settings))
    state, before, flagged = mhe.init(), None, 0
    for measurement in RUN.measurements:
        state, estimate = mhe.step(state, measurement)
        assert is_finite(estimate)
        assert estimate.iterations <= mhe.config.max_iterations
        problem = pens.pen_batch(
            list(state.measurements), state.prior.mean, np.linalg.cholesky(state.prior.covariance)
        )
        assert estimate.window is not None
        cost, start = problem.cost(estimate.window.states), warm_start(before, state)
        assert cost <= problem.cost(start) * (1 + 1e-9)
        flagged += flag in estimate.status
        assert estimate.status.is_solved == (flag not in estimate.status)
        before = estimate
    assert flagged >= len(RUN.measurements) // 2


def test_one_iteration_is_better_than_none() -> None:
    """The best point is not merely the warm start."""
    costs = []
    for iterations in (0, 1, 3):
        mhe = MheIpopt(RUN.model, MheIpoptConfig(horizon=13, max_iterations=iterations))
        state = mhe.init()
        for measurement in RUN.measurements[:6]:
            state, estimate = mhe.step(state, measurement)
        assert estimate.window is not None
        costs.append(pens.pen_batch(RUN.measurements[:6]).cost(estimate.window.states))
    assert costs[2] < 0.5 * costs[0]
    assert costs[1] < costs[0]


def test_constraints_that_cannot_be_met_are_infeasible() -> None:
    system, rng = coupled_system(4), np.random.default_rng(71)
    measurements = system.simulate(irregular_times(8, rng), rng)
    # Not affine: `constrained` itself refuses an affine row that no state meets.
    model = system.model.bounded(s0_m=(-np.inf, 0.0)).constrained(lambda x: 1.0 - ca.sinh(x[0]))
    mhe = MheIpopt(model, MheIpoptConfig(horizon=3))
    state = mhe.init()
    for measurement in measurements:
        state, estimate = mhe.step(state, measurement)
        assert not estimate.status.is_solved
        assert is_finite(estimate)
        assert Status.INFEASIBLE in estimate.status


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_measurement_beyond_the_window_is_flagged_and_changes_nothing(estimator: str) -> None:
    mhe = ESTIMATORS[estimator](RUN.model, config_for(estimator, horizon=4))
    state = mhe.init()
    for measurement in RUN.measurements[:8]:
        state, before = mhe.step(state, measurement)
    late = Measurement(RUN.measurements[2].time_s, RUN.measurements[10].y)
    after, estimate = mhe.step(state, late)
    assert Status.LATE in estimate.status
    assert Status.NO_READING not in estimate.status
    assert estimate.time_s == before.time_s
    np.testing.assert_array_equal(estimate.state.mean, before.state.mean)
    np.testing.assert_allclose(estimate.state.covariance, before.state.covariance, rtol=1e-12)
    _, one = mhe.step(state, RUN.measurements[8])
    _, other = mhe.step(after, RUN.measurements[8])
    np.testing.assert_array_equal(one.state.mean, other.state.mean)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_no_reading_is_flagged_and_gives_the_prediction(estimator: str) -> None:
    system, rng = constant_acceleration_system(1), np.random.default_rng(72)
    measurements = system.simulate(irregular_times(9, rng), rng, missing=0.0)
    mhe = ESTIMATORS[estimator](system.model, config_for(estimator, horizon=3))
    state = mhe.init()
    for measurement in measurements:
        state, before = mhe.step(state, measurement)
    _, estimate = mhe.step(state, Measurement(before.time_s + 0.2, np.full(2, np.nan)))
    F = system.F(0.2)
    assert estimate.status is Status.NO_READING
    std = estimate.state.std
    assert np.abs((estimate.state.mean - F @ before.state.mean) / std).max() < 1e-9
    wanted_P = F @ before.state.covariance @ F.T + system.Q(0.2)
    assert np.abs((estimate.state.covariance - wanted_P) / np.outer(std, std)).max() < 1e-9
    assert np.isnan(estimate.innovation).all()


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("bad", [np.inf, -np.inf])
def test_an_infinite_reading_is_flagged_and_counts_as_missing(bad: float, estimator: str) -> None:
    system, rng = coupled_system(4), np.random.default_rng(73)
    measurements = system.simulate(irregular_times(6, rng), rng, missing=0.0)
    mhe = ESTIMATORS[estimator](system.model, config_for(estimator, horizon=3))
    state = mhe.init()
    for measurement in measurements:
        state, _ = mhe.step(state, measurement)
    time_s, y = measurements[-1].time_s + 0.02, np.array([bad, 0.1, 0.1])
    _, estimate = mhe.step(state, Measurement(time_s, y))
    _, wanted = mhe.step(state, Measurement(time_s, np.where(np.isinf(y), np.nan, y)))
    assert Status.INFINITE_READING in estimate.status
    assert is_finite(estimate)
    np.testing.assert_allclose(estimate.state.mean, wanted.state.mean, rtol=0, atol=1e-12)
