"""A window over all stages is the batch least-squares problem, solved by SciPy."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from estimation.estimator import Estimator
from estimation.recording import Measurement
from models.gaussian import GaussianState
from tests.configs import config_for
from tests.estimation import pens
from tests.linear_models import (
    LinearSystem,
    constant_acceleration_system,
    coupled_system,
    irregular_times,
)
from tests.mhe.runs import ESTIMATORS, ON_A_PEN, full_length, linear_batch, run_mhe
from tests.references.batch import Solution

TOLERANCE_STD = 1e-6
N_STAGES = 16


@pytest.mark.cover
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("system", [constant_acceleration_system(2), coupled_system(9)])
def test_linear_window(system: LinearSystem, estimator: str) -> None:
    rng = np.random.default_rng(41)
    measurements = system.simulate(irregular_times(20, rng), rng)
    config = config_for(estimator, horizon=19, reuse_threshold=0.0)
    newest = run_mhe(system.model, measurements, config, estimator)[-1]
    wanted = linear_batch(system, measurements).solve()
    assert newest.window is not None
    assert np.abs((newest.window.states - wanted.states) / wanted.std).max() < TOLERANCE_STD
    assert np.abs(newest.state.std / wanted.std[-1] - 1).max() < TOLERANCE_STD


@pytest.fixture(scope="module", params=ON_A_PEN)
def pen_mhe(request: pytest.FixtureRequest) -> Estimator[Any]:
    run = pens.draw_pen_run(N_STAGES, seed=0)
    config = config_for(request.param, horizon=full_length(run.measurements))
    return ESTIMATORS[request.param](run.model, config)


def newest_states(mhe: Estimator[Any], measurements: list[Measurement]) -> np.ndarray:
    state = mhe.init()
    for measurement in measurements:
        state, estimate = mhe.step(state, measurement)
        assert estimate.status.is_solved
    assert estimate.window is not None
    return estimate.window.states


@cache
def pen_optimum(seed: int, n: int = N_STAGES, azimuth: float = pens.PRIOR_MEAN[3]) -> Solution:
    """The reference's optimum of the first n measurements of a run."""
    mean = pens.PRIOR_MEAN.copy()
    mean[3] = azimuth
    measurements = pens.draw_pen_run(N_STAGES, seed, mean=mean).measurements[:n]
    problem = pens.pen_batch(measurements, mean=mean)
    solution = problem.solve()
    gradient = problem.jacobian(solution.z).T @ problem.residual(solution.z)
    assert np.abs(gradient).max() < 1e-5, "the reference did not converge"
    return solution


@pytest.mark.parametrize("seed", [*(pytest.param(n, marks=pytest.mark.slow) for n in (0, 2)), 1])
def test_pen_window(pen_mhe: Estimator[Any], seed: int) -> None:
    measurements = pens.draw_pen_run(N_STAGES, seed).measurements
    y = np.array([m.y for m in measurements])
    assert 0.2 < np.isnan(y).mean() < 0.8
    states = newest_states(pen_mhe, measurements)
    wanted = pen_optimum(seed)
    assert np.abs((states - wanted.states) / wanted.std).max() < TOLERANCE_STD


def test_growing_pen_windows(pen_mhe: Estimator[Any]) -> None:
    """Windows that still grow have the optimum of their own stages."""
    measurements = pens.draw_pen_run(N_STAGES, seed=1).measurements
    state = pen_mhe.init()
    for k, measurement in enumerate(measurements[:9]):
        state, estimate = pen_mhe.step(state, measurement)
        if k not in (1, 4, 8):
            continue
        wanted = pen_optimum(1, k + 1)
        assert estimate.window is not None
        error = (estimate.window.states - wanted.states) / wanted.std
        assert np.abs(error).max() < TOLERANCE_STD
        assert np.abs(estimate.state.std / wanted.std[-1] - 1).max() < TOLERANCE_STD


@pytest.mark.parametrize("estimator", ON_A_PEN)
def test_pen_window_across_half_a_turn(estimator: str) -> None:
    """Azimuth passes ±π inside the window; the reference does not wrap, the MHE does."""
    turned = pens.PRIOR_MEAN.copy()
    turned[3] = np.pi - 0.05
    run = pens.draw_pen_run(N_STAGES, seed=13, mean=turned)
    prior = GaussianState(turned, np.diag(pens.PRIOR_STD**2))
    config = config_for(estimator, horizon=full_length(run.measurements))
    mhe = ESTIMATORS[estimator](run.model.replace(prior=prior), config)
    states = newest_states(mhe, run.measurements)
    wanted = pen_optimum(13, azimuth=turned[3])
    azimuth = wanted.states[:, 3]
    assert azimuth.min() < np.pi < azimuth.max(), "the case does not cross"
    assert np.abs(states[:, 3]).max() <= np.pi
    difference = states - wanted.states
    difference[:, 3] = np.angle(np.exp(1j * difference[:, 3]))
    assert np.abs(difference / wanted.std).max() < TOLERANCE_STD
