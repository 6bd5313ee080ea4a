"""A window over all stages is the batch least-squares problem, solved by SciPy."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.config import MheConfig
from mhe.ipopt import MheIpopt
from models.gaussian import GaussianState
from tests.estimation import pens
from tests.linear_models import (
    LinearSystem,
    constant_acceleration_system,
    coupled_system,
    irregular_times,
)
from tests.mhe.runs import full_length, linear_batch, run_mhe
from tests.references.batch import BatchProblem, Solution

TOLERANCE_STD = 1e-6
N_STAGES = 16


@pytest.mark.parametrize("system", [constant_acceleration_system(2), coupled_system(9)])
def test_linear_window(system: LinearSystem) -> None:
    rng = np.random.default_rng(41)
    measurements = system.simulate(irregular_times(20, rng), rng)
    newest = run_mhe(system.model, measurements, MheConfig(horizon=19))[-1]
    wanted = linear_batch(system, measurements).solve()
    assert newest.window is not None
    assert np.abs((newest.window.states - wanted.states) / wanted.std).max() < TOLERANCE_STD
    assert np.abs(newest.state.std / wanted.std[-1] - 1).max() < TOLERANCE_STD


@pytest.fixture(scope="module")
def pen_mhe() -> MheIpopt:
    run = pens.draw_pen_run(N_STAGES, seed=0)
    return MheIpopt(run.model, MheConfig(horizon=full_length(run.measurements)))


def newest_states(mhe: MheIpopt, measurements: list[Measurement]) -> np.ndarray:
    state = mhe.init()
    for measurement in measurements:
        state, estimate = mhe.step(state, measurement)
        assert estimate.status.is_solved
    assert estimate.window is not None
    return estimate.window.states


def solve_batch(problem: BatchProblem) -> Solution:
    solution = problem.solve()
    gradient = problem.jacobian(solution.z).T @ problem.residual(solution.z)
    assert np.abs(gradient).max() < 1e-5, "the reference did not converge"
    return solution


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_pen_window(pen_mhe: MheIpopt, seed: int) -> None:
    measurements = pens.draw_pen_run(N_STAGES, seed).measurements
    y = np.array([m.y for m in measurements])
    assert 0.2 < np.isnan(y).mean() < 0.8
    states = newest_states(pen_mhe, measurements)
    wanted = solve_batch(pens.pen_batch(measurements))
    assert np.abs((states - wanted.states) / wanted.std).max() < TOLERANCE_STD


def test_growing_pen_windows(pen_mhe: MheIpopt) -> None:
    """Windows that are still padded have the optimum of their own stages."""
    measurements = pens.draw_pen_run(N_STAGES, seed=1).measurements
    state = pen_mhe.init()
    for k, measurement in enumerate(measurements[:9]):
        state, estimate = pen_mhe.step(state, measurement)
        if k not in (1, 4, 8):
            continue
        wanted = solve_batch(pens.pen_batch(measurements[: k + 1]))
        assert estimate.window is not None
        error = (estimate.window.states - wanted.states) / wanted.std
        assert np.abs(error).max() < TOLERANCE_STD
        assert np.abs(estimate.state.std / wanted.std[-1] - 1).max() < TOLERANCE_STD


def test_pen_window_across_half_a_turn() -> None:
    """Azimuth passes ±π inside the window; the reference does not wrap, the MHE does."""
    turned = pens.PRIOR_MEAN.copy()
    turned[3] = np.pi - 0.05
    run = pens.draw_pen_run(N_STAGES, seed=13, mean=turned)
    prior = GaussianState(turned, np.diag(pens.PRIOR_STD**2))
    mhe = MheIpopt(run.model.replace(prior=prior), MheConfig(horizon=full_length(run.measurements)))
    states = newest_states(mhe, run.measurements)
    wanted = solve_batch(pens.pen_batch(run.measurements, mean=turned))
    azimuth = wanted.states[:, 3]
    assert azimuth.min() < np.pi < azimuth.max(), "the case does not cross"
    assert np.abs(states[:, 3]).max() <= np.pi
    difference = states - wanted.states
    difference[:, 3] = np.angle(np.exp(1j * difference[:, 3]))
    assert np.abs(difference / wanted.std).max() < TOLERANCE_STD
