"""The descent to a window's optimum cannot diverge: its cost never rises."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.config import MheConfig
from mhe.realtime import Mhe
from mhe.trajectory import Trajectory, WindowSolution
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from tests.estimation import pens
from tests.mhe import pendulum
from tests.references.gauss_newton import DenseWindow, gauss_newton_step

N = 9
PASSES = (0, 1, 2, 3, 4, 5, 6, 8, 11, 15, 20, 300)
ROUNDING = 1e-11
"""Of a cost: from here on a descent settles by the length of its steps, not by the cost."""

RUN = pens.draw_pen_run(N, seed=6)
CASES: dict[str, tuple[StateSpaceModel, list[Measurement]]] = {
    "pen": (RUN.model, RUN.measurements),
    "pendulum": (pendulum.model(), pendulum.simulate(N, seed=5)),
}


def bad_start(model: StateSpaceModel, window: DenseWindow, seed: int) -> Trajectory:
    """A first state up to three standard deviations off, and noises as far."""
    rng = np.random.default_rng(seed)
    w = 2 * rng.standard_normal((N - 1, model.n_w))
    states = [model.prior.mean + model.prior.std * rng.uniform(-3, 3, model.n_x)]
    for noise, dt in zip(w, window.dt, strict=True):
        states.append(np.asarray(model.f(states[-1], noise, dt)).ravel())
    return Trajectory(np.array(states), w)


@cache
def solver(name: str, passes: int, has_losses: bool = False) -> Mhe:
    model = CASES[name][0]
    losses: dict[str, Any] = {"huber": {model.sensors[0].name: 1.0}, "sparse_noise": 1.0}
    settings = losses if has_losses else {}
    return Mhe(model, MheConfig(horizon=N - 1, max_iterations=passes, **settings))


def after_passes(name: str, start: Trajectory, has_losses: bool) -> list[WindowSolution]:
    """Where the descent stands after some passes."""
    model, measurements = CASES[name]
    window = model.prior, tuple(measurements), start
    return [solver(name, passes, has_losses).solve(*window) for passes in PASSES]


@pytest.mark.cover
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", CASES)
def test_the_cost_never_rises(name: str, seed: int) -> None:
    model, measurements = CASES[name]
    window = DenseWindow(model, model.prior, measurements)
    start = bad_start(model, window, seed)
    found = after_passes(name, start, has_losses=False)
    costs = np.array([solution.cost for solution in found])
    assert (np.diff(costs) <= ROUNDING * costs[:-1]).all(), costs
    for solution in found:
        z = window.start(solution.trajectory)
        assert solution.cost == pytest.approx(window.cost(z), rel=1e-9)
    assert costs[0] == pytest.approx(window.cost(window.start(start)), rel=1e-9)
    assert costs[-1] < 0.9 * costs[0]
    assert not found[2].status.is_solved


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", CASES)
def test_a_loss_never_rises(name: str, seed: int) -> None:
    model, measurements = CASES[name]
    start = bad_start(model, DenseWindow(model, model.prior, measurements), seed)
    found = after_passes(name, start, has_losses=True)
    costs = np.array([solution.cost for solution in found])
    assert (np.diff(costs) <= ROUNDING * costs[:-1]).all(), costs
    assert costs[-1] < 0.9 * costs[0]


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("name", CASES)
def test_it_ends_at_a_minimum(name: str, seed: int) -> None:
    """Where it says solved, an independent Gauss-Newton step from there goes nowhere."""
    model, measurements = CASES[name]
    window = DenseWindow(model, model.prior, measurements)
    start = bad_start(model, window, seed)
    found = solver(name, 300).solve(model.prior, tuple(measurements), start)
    arrays = found.trajectory.states, found.trajectory.noises, found.newest.covariance
    assert all(np.isfinite(array).all() for array in arrays)
    assert found.status.is_solved
    r, J, _ = window.linearised(window.start(found.trajectory))
    assert np.linalg.norm(J @ gauss_newton_step(r, J)) < 1e-6


def test_full_steps_alone_would_rise() -> None:
    """The cases have teeth: from some of these starts a full step costs more."""
    model, measurements = CASES["pendulum"]
    window, risen = DenseWindow(model, model.prior, measurements), 0
    for seed in range(30):
        z = window.start(bad_start(model, window, seed))
        r, J, _ = window.linearised(z)
        risen += window.cost(z + gauss_newton_step(r, J)) > window.cost(z)
    assert risen >= 1


@pytest.mark.parametrize("seed", range(3))
def test_a_prior_that_is_sure_of_a_state(seed: int) -> None:
    """A singular covariance has no Cholesky factor; nothing needs one."""
    model, measurements = CASES["pen"]
    sure = model.prior.covariance.copy()
    sure[3, :] = sure[:, 3] = 0.0
    nearly = sure.copy()
    nearly[3, 3] = 1e-14
    mhe = Mhe(model, MheConfig(horizon=N - 1))
    start = bad_start(model, DenseWindow(model, model.prior, measurements), seed)
    start.states[0, 3] = model.prior.mean[3]
    found = [
        mhe.solve(GaussianState(model.prior.mean, P), tuple(measurements), start)
        for P in (sure, nearly)
    ]
    assert all(solution.status.is_solved for solution in found)
    assert found[0].trajectory.states[0, 3] == pytest.approx(model.prior.mean[3], abs=1e-12)
    assert found[0].cost == pytest.approx(found[1].cost, rel=1e-6)


def test_a_start_that_does_not_obey_the_dynamics_is_made_to() -> None:
    """The optimum's states without its noises would seem better than the optimum."""
    model, measurements = CASES["pen"]
    mhe, window = Mhe(model, MheConfig(horizon=N - 1)), (model.prior, tuple(measurements))
    dense = DenseWindow(model, model.prior, measurements)
    start = dense.trajectory(np.zeros(dense.n_z))
    wanted = mhe.solve(*window, start)
    without = Trajectory(wanted.trajectory.states, np.zeros((N - 1, model.n_w)))
    found = mhe.solve(*window, without)
    assert found.status.is_solved
    assert found.cost == pytest.approx(wanted.cost, rel=1e-9)
