"""One pass of `mhe-rti` is one Gauss-Newton step of its window, written down densely."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import cho_factor, cho_solve

from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.gaussian import GaussianState
from tests.closeness import covariance_error, mean_error
from tests.estimation import pens
from tests.mhe import pendulum
from tests.mhe.windows import Moved, moves
from tests.references.gauss_newton import DenseWindow, gauss_newton_step
from tests.references.multiple_shooting import gauss_newton_step as multiple_shooting_step

TOLERANCE = 1e-8
RUN = pens.draw_pen_run(14, seed=4)


def largest_error(move: Moved, wanted: Trajectory, covariance: Array, mhe: MheRti) -> float:
    """Of all states, all noises and the newest covariance, in standard deviations."""
    spread = GaussianState(wanted.states[-1], covariance)
    errors = [covariance_error(move.estimate.state.covariance, covariance)]
    for x, other in zip(move.found.states, wanted.states, strict=True):
        errors.append(mean_error(mhe.model, x, GaussianState(other, spread.covariance)))
    errors.append(float(np.abs(move.found.noises - wanted.noises).max(initial=0.0)))
    return max(errors)


@pytest.mark.cover
@pytest.mark.parametrize("arrival_cost", ["filtered", "smoothed", "constant"])
@pytest.mark.parametrize("horizon", [1, 5, 13])
def test_on_the_pen(horizon: int, arrival_cost: str) -> None:
    config = MheRtiConfig(horizon=horizon, arrival_cost=arrival_cost, reuse_threshold=0.0)
    mhe = MheRti(RUN.model, config)
    moved = []
    for move in moves(mhe, RUN.measurements):
        window = DenseWindow(RUN.model, move.prior, move.measurements)
        z = window.start(move.guess)
        r, J, X = window.linearised(z)
        wanted = window.trajectory(z + gauss_newton_step(r, J))
        covariance = X @ cho_solve(cho_factor(J.T @ J), X.T)
        assert largest_error(move, wanted, covariance, mhe) < TOLERANCE
        spread = GaussianState(move.guess.states[-1], covariance)
        moved.append(mean_error(RUN.model, move.found.states[-1], spread))
    assert max(moved) > 1.0, "no step moved anything"


@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize("horizon", [2, 8])
def test_on_a_pendulum_whose_trajectory_does_not_obey_its_dynamics(horizon: int, seed: int) -> None:
    """A pass makes the linearised window's optimum the trajectory: the pendulum is curved."""
    mhe = MheRti(pendulum.model(), MheRtiConfig(horizon=horizon, reuse_threshold=0.0))
    defects = []
    for move in moves(mhe, pendulum.simulate(25, seed)):
        times, y = [m.time_s for m in move.measurements], [m.y for m in move.measurements]
        x, w = move.guess.states, move.guess.noises

        def step(k: int, x: Array, w: Array, times: list[float] = times) -> tuple[Array, ...]:
            dt = times[k + 1] - times[k]
            return pendulum.step(x, w, dt), *pendulum.derivatives(x, w, dt)

        def readings(k: int, x: Array, y: list[Array] = y) -> tuple[Array, Array]:
            there, std = ~np.isnan(y[k]), np.array([pendulum.SINE_STD, pendulum.RATE_STD])
            residual = (y[k] - [np.sin(x[0]), x[1]]) / std
            J = -np.diag([np.cos(x[0]), 1.0]) / std[:, None]
            return residual[there], J[there]

        prior = move.prior.mean, move.prior.covariance
        states, noises, covariance = multiple_shooting_step(prior, (x, w), step, readings)
        assert largest_error(move, Trajectory(states, noises), covariance, mhe) < TOLERANCE
        defects += [np.abs(step(k, x[k], w[k])[0] - x[k + 1]).max() for k in range(len(w))]
    assert max(defects) > 1e-3, "every trajectory obeyed its dynamics"


@pytest.mark.parametrize("seed", [7, 8, 9])
def test_the_first_iteration_is_a_part_of_that_step(seed: int) -> None:
    """`mhe` halves it until the cost falls."""
    run, n = pens.draw_pen_run(9, seed), 9
    mhe = Mhe(run.model, MheConfig(horizon=n - 1, max_iterations=1))
    window = DenseWindow(run.model, run.model.prior, run.measurements)
    zero = np.zeros(window.n_z)
    r, J, _ = window.linearised(zero)
    step = gauss_newton_step(r, J)
    found = mhe.solve(run.model.prior, tuple(run.measurements), window.trajectory(zero))
    share = found.trajectory.noises.ravel() / step[15:]
    np.testing.assert_allclose(share, share[0], rtol=1e-6)
    assert np.log2(share[0]) == pytest.approx(round(np.log2(share[0])), abs=1e-6)
    assert found.cost == pytest.approx(window.cost(share[0] * step), rel=1e-9)
    assert found.cost < window.cost(zero)
