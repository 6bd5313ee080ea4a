"""Windows solved by a sequence of QPs: SciPy's and IPOPT's optimum, weak rows, limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig, MheIpoptConfig
from mhe.constraint_rows import constrain_function
from mhe.reference.ipopt import MheIpopt
from mhe.sparse_qp.sequential_qp import ConstrainedSolution, SequentialQp
from models.errors import InputError
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from suites.optimum.cases import rolled_out
from tests.estimation import pens
from tests.linear_models import constant_acceleration_system, coupled_system
from tests.mhe import pendulum
from tests.mhe.runs import linear_batch
from tests.references.constrained import solve_constrained
from tests.references.least_distance import solve_held

pytestmark = pytest.mark.usefixtures("interpreted")

N_STAGES = 9
TIGHT = MheConfig(horizon=N_STAGES - 1, tolerance=1e-10, max_iterations=100)


def solve(
    model: StateSpaceModel, measurements: list[Measurement], config: MheConfig = TIGHT
) -> ConstrainedSolution:
    """From the prior's mean, without noise."""
    window = tuple(measurements)
    guess = rolled_out(model, model.prior.mean, window)
    return SequentialQp(model, config).solve_window(model.prior, window, guess)


def test_a_prior_without_a_factor_is_an_outcome() -> None:
    system = constant_acceleration_system(1)
    model = system.model.replace(lower=np.full(system.model.n_x, -1e3))
    measurements = tuple(system.simulate(0.1 * np.arange(4), np.random.default_rng(0), missing=0.0))
    prior = GaussianState(model.prior.mean, -np.eye(model.n_x))
    guess = rolled_out(model, model.prior.mean, measurements)
    found = SequentialQp(model, TIGHT).solve_window(prior, measurements, guess)
    assert found.solution.status is Status.NOT_FINITE
    assert np.isnan(found.solution.cost)


@pytest.mark.slow
def test_a_pen_above_its_desk_and_beside_a_wall() -> None:
    """SciPy's SLSQP, with its active set made exact, finds the same."""
    run = pens.draw_pen_run(N_STAGES, seed=0)
    free = pens.pen_batch(run.measurements).solve().states
    desk, wall = np.quantile(free[:, 2], 0.6), np.quantile(free[:, 0] + free[:, 1], 0.4)
    model = run.model.bounded(tip_z_m=(desk, np.inf)).constrained(lambda x: x[0] + x[1] - wall)
    C, d = np.zeros((2, 15)), np.array([-desk, wall])
    C[0, 2], C[1, :2] = -1, 1
    wanted = solve_constrained(pens.pen_batch(run.measurements), C, d)
    found = solve(model, run.measurements)
    trajectory = found.solution.trajectory
    assert found.solution.status is Status.SOLVED
    assert found.length <= TIGHT.tolerance
    assert np.abs((trajectory.states - wanted.states) / wanted.std).max() < 1e-8
    assert found.solution.cost == pytest.approx(wanted.cost, rel=1e-10)
    assert np.array_equal(found.multipliers > 1e-6, wanted.active)
    assert wanted.active.any()


def test_a_linear_window_is_one_step() -> None:
    """The first step is the optimum, the second stands still."""
    system, rng = coupled_system(3), np.random.default_rng(2)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, N_STAGES)), rng)
    problem = linear_batch(system, measurements)
    high = float(np.median(problem.solve().states[:, 0]))
    model = system.model.bounded(s0_m=(-np.inf, high))
    everywhere = np.ones((N_STAGES, 1), dtype=bool)
    wanted = solve_held(problem, np.eye(1, 4), np.array([high]), everywhere)
    found = solve(model, measurements)
    assert found.solution.iterations == 2
    assert np.abs((found.solution.trajectory.states - wanted.states) / wanted.std).max() < 1e-9
    assert found.multipliers == pytest.approx(wanted.multipliers, rel=1e-7, abs=1e-9)
    assert found.solution.cost == pytest.approx(wanted.cost, rel=1e-12)
    assert (wanted.multipliers > 0).sum() >= 2


PEN = pens.draw_pen_run(N_STAGES, 2)
NONLINEAR: Mapping[str, tuple[StateSpaceModel, list[Measurement], dict[str, Any]]] = {
    "pen in a circle": (
        PEN.model.constrained(lambda x: (x[0] ** 2 + x[1] ** 2) / 0.1**2 - 1.0),
        PEN.measurements,
        {},
    ),
    "pendulum": (
        pendulum.model().bounded(s0_m=(-0.2, 0.3), s1_m=(-2.0, 1.0)),
        pendulum.simulate(N_STAGES, 2),
        {},
    ),
    "pendulum, losses": (
        pendulum.model().bounded(s0_m=(-0.2, 0.3)),
        pendulum.simulate(N_STAGES, 2),
        {"huber": {"level": 1.0}, "sparse_noise": 0.5},
    ),
}


@pytest.mark.parametrize("name", NONLINEAR)
def test_the_optimum_is_ipopts(name: str) -> None:
    model, measurements, losses = NONLINEAR[name]
    tight = {"horizon": N_STAGES - 1, "tolerance": 1e-10, "max_iterations": 500, **losses}
    window = tuple(measurements)
    guess = rolled_out(model, model.prior.mean, window)
    wanted = MheIpopt(model, MheIpoptConfig(**tight)).solve(model.prior, window, guess)
    found = solve(model, measurements, MheConfig(**tight))
    std = wanted.newest.std
    apart = found.solution.trajectory.states - wanted.trajectory.states
    assert found.solution.status is Status.SOLVED
    assert np.abs(apart / std).max() < 1e-6
    assert found.solution.cost == pytest.approx(wanted.cost, rel=1e-9)
    g = [constrain_function(model)(x)[0].full().ravel() for x in found.solution.trajectory.states]
    assert (np.array(g) < 1e-9).all()
    assert np.abs(found.multipliers * np.array(g)).max() < 1e-6
    assert (found.multipliers > 1e-3).any()
    newest, other = found.solution.newest.covariance, wanted.newest.covariance
    assert newest / np.outer(std, std) == pytest.approx(other / np.outer(std, std), abs=1e-5)


def test_a_row_that_the_free_optimum_just_touches_changes_nothing() -> None:
    """It is weakly active: without a barrier the optimum stays where it is, to rounding."""
    system, rng = constant_acceleration_system(1), np.random.default_rng(2)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, N_STAGES)), rng)
    free = linear_batch(system, measurements).solve()
    highest = float(free.states[:, 0].max())
    found = solve(system.model.bounded(s0_m=(-np.inf, highest)), measurements)
    states = found.solution.trajectory.states
    assert np.abs((states - free.states) / free.std).max() < 1e-9
    assert found.multipliers.max() * free.std[:, 0].max() < 1e-9
    assert abs(states[:, 0].max() - highest) < 1e-12


def test_shorter_windows_and_longer_ones() -> None:
    """A solver of N intervals takes windows of fewer; more are refused."""
    system, rng = constant_acceleration_system(1), np.random.default_rng(2)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, N_STAGES + 1)), rng)
    model, solver = system.model.bounded(s0_m=(-np.inf, 0.0)), SequentialQp(system.model, TIGHT)
    everywhere = np.ones((N_STAGES, 1), dtype=bool)
    bounded = SequentialQp(model, TIGHT)
    for n in (1, 4, N_STAGES):
        window = tuple(measurements[:n])
        guess = rolled_out(model, model.prior.mean, window)
        problem = linear_batch(system, measurements[:n])
        wanted = solve_held(problem, np.eye(1, 3), np.zeros(1), everywhere[:n])
        found = bounded.solve(model.prior, window, guess)
        assert np.abs((found.trajectory.states - wanted.states) / wanted.std).max() < 1e-9
        free = solver.solve(model.prior, window, guess)
        textbook = system.textbook(measurements[:n])[-1]
        assert free.newest.mean == pytest.approx(textbook.mean, rel=1e-9)
        assert free.newest.covariance == pytest.approx(textbook.covariance, rel=1e-8)
    guess = rolled_out(model, model.prior.mean, tuple(measurements))
    with pytest.raises(InputError, match="a window of 10 measurements, expected 1 to 9"):
        bounded.solve(model.prior, tuple(measurements), guess)


def test_limits_are_told() -> None:
    model, measurements, _ = NONLINEAR["pendulum"]
    few = MheConfig(horizon=N_STAGES - 1, tolerance=1e-10, max_iterations=2)
    found = solve(model, measurements, few)
    assert (found.solution.status, found.solution.iterations) == (Status.ITERATION_LIMIT, 2)
    assert np.isfinite(found.solution.cost)
    both = [f"level_{i}" for i in (0, 1)]
    model = pendulum.model().constrained(lambda x: x[0] + 1, needs=both[:1])
    model = model.constrained(lambda x: 1 - x[0], needs=both[1:])
    full = [Measurement(m.time_s, np.zeros(2)) for m in measurements]
    assert solve(model, full).solution.status is Status.INFEASIBLE
