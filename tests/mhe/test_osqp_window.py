"""The window's QP in OSQP: the pass' optimum without constraints, the exact one with them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig
from mhe.interpreted.window_pass import WindowPass
from mhe.sparse_qp.osqp_window import OsqpWindow
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from tests.estimation import pens
from tests.linear_models import LinearSystem, constant_acceleration_system, coupled_system
from tests.mhe import pendulum
from tests.mhe.linearised_windows import bounded_stream, linearised, run
from tests.mhe.runs import linear_batch
from tests.references.least_distance import solve_held

pytestmark = pytest.mark.usefixtures("interpreted")

TOLERANCE = 1e-9
"""Standard deviations; OSQP polishes its optimum to about 1e-12."""
N_STAGES = 9


CASES: dict[str, Any] = {
    "pen": (
        pens.draw_pen_run(N_STAGES, 3).model,
        pens.draw_pen_run(N_STAGES, 3).measurements,
        {"tip_z_m": (0.12, np.inf), "tip_y_velocity_m_s": (-0.1, 0.1)},
    ),
    "pendulum": (
        pendulum.model(),
        pendulum.simulate(N_STAGES, 2),
        {"s0_m": (-0.2, 0.1), "s1_m": (-2.0, 1.0)},
    ),
    "coupled": (
        coupled_system(3).model,
        coupled_system(3).simulate(0.1 * np.arange(N_STAGES), np.random.default_rng(1)),
        {"s0_m": (-0.1, 0.1), "s1_m": (-np.inf, 0.0)},
    ),
}


@pytest.mark.cover
@pytest.mark.parametrize("is_bounded", [False, True], ids=["free", "bounded"])
@pytest.mark.parametrize("losses", [False, True], ids=["least squares", "reweighted"])
@pytest.mark.parametrize("name", CASES)
def test_the_optimum_of_the_pass(name: str, losses: bool, is_bounded: bool) -> None:
    """Trajectories that do not obey the dynamics, far from the prior, with noises."""
    free, measurements, bounds = CASES[name]
    model = free.bounded(**bounds) if is_bounded else free
    scales = {"noise_scale": 3.0, "row_scale": 0.3} if losses else {}
    window = linearised(model, measurements, seed=4, **scales)
    passes = WindowPass(model, MheConfig(horizon=N_STAGES - 1))
    wanted, found = (
        passes.run(window.view, window.d, window.scales),
        run(window, OsqpWindow(model, N_STAGES)),
    )
    std = np.sqrt(np.diagonal(wanted.covariances, axis1=1, axis2=2))
    assert found.solved
    assert np.abs((found.d - wanted.d) / std).max() < TOLERANCE
    assert np.abs(found.w - wanted.w).max() < TOLERANCE
    of_prior = (wanted.mu - np.linalg.solve(model.prior.covariance, window.d)) @ wanted.d[0]
    assert found.length**2 == pytest.approx(wanted.length + of_prior, rel=1e-9)
    multipliers = wanted.held.multipliers.reshape(window.demanded.shape)
    assert found.multipliers.shape == multipliers.shape
    unit = wanted.row_std
    assert np.abs((found.multipliers - multipliers) * unit).max(initial=0.0) < TOLERANCE
    assert (multipliers > 0).sum() >= (2 if is_bounded else 0)
    newest = wanted.newest.state.covariance
    assert found.newest == pytest.approx(newest, rel=1e-9, abs=1e-12 * np.abs(newest).max())


HELD = {
    "one axis": (constant_acceleration_system(1), 5, 0.3),
    "two axes": (constant_acceleration_system(2), 1, 0.3),
    "coupled": (coupled_system(3), 2, 0.3),
    "coupled, much missing": (coupled_system(5), 6, 0.6),
}


def conditional(system: LinearSystem, measurements: list[Measurement]) -> tuple[Any, Array, Array]:
    """Two bounds, always; s0 + s1 <= c where the first reading is there. Also as C x <= d."""
    states = linear_batch(system, measurements).solve().states
    high, low = np.quantile(states[:, 0], 0.7), np.median(states[:, 1])
    total = np.quantile(states[:, 0] + states[:, 1], 0.3)
    model = system.model.bounded(s0_m=(-np.inf, high), s1_m=(low, np.inf)).constrained(
        lambda x: x[0] + x[1] - total, needs=[system.model.reading_names[0]]
    )
    C = np.zeros((3, model.n_x))  # lower bounds stand in front of upper ones
    C[0, 1], C[1, 0], C[2, :2] = -1, 1, 1
    return model, C, np.array([-low, high, total])


@pytest.mark.parametrize("name", HELD)
def test_rows_that_hold(name: str) -> None:
    """The exact optimum and multipliers of linear windows, with rows that some stages demand."""
    system, seed, missing = HELD[name]
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.05, 0.2, N_STAGES))
    measurements = system.simulate(times, rng, missing=missing)
    model, C, d = conditional(system, measurements)
    window = linearised(model, measurements, seed)
    wanted = solve_held(linear_batch(system, measurements), C, d, window.demanded)
    found = run(window, OsqpWindow(model, N_STAGES))
    states = window.view.x + found.d
    assert np.abs((states - wanted.states) / wanted.std).max() < TOLERANCE
    # The model may shake in another basis than the reference.
    noises = wanted.z[model.n_x :].reshape(found.w.shape)
    lengths = np.linalg.norm(found.w, axis=1), np.linalg.norm(noises, axis=1)
    assert np.abs(lengths[0] - lengths[1]).max() < TOLERANCE
    assert found.multipliers == pytest.approx(wanted.multipliers, rel=1e-7, abs=1e-9)
    assert not found.multipliers[~window.demanded].any()
    assert 0 < window.demanded[:, 2].sum() < N_STAGES
    assert (wanted.multipliers[:, 2] > 0).any(), "the conditional row never holds"
    beyond = (states @ C.T > d + 1e-6) & ~window.demanded
    assert beyond.any(), "the row would hold where it is not demanded"


def test_a_multiplier_is_what_a_row_costs() -> None:
    """dJ / d(limit) = -ν: central differences are exact to second order on a quadratic."""
    system, rng = constant_acceleration_system(1), np.random.default_rng(4)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, N_STAGES)), rng, missing=0.2)
    problem = linear_batch(system, measurements)
    limit = float(problem.solve().states[:, 0].min())
    found = []
    for shift in (-1e-4, 0.0, 1e-4):
        model = system.model.bounded(s0_m=(-np.inf, limit + shift))
        window = linearised(model, measurements, seed=0)
        found.append((window.view.x, run(window, OsqpWindow(model, N_STAGES))))
    costs = [problem.cost(x + solution.d) for x, solution in found]
    multipliers = found[1][1].multipliers
    assert (multipliers > 0).sum() >= 2
    assert multipliers.sum() == pytest.approx((costs[0] - costs[2]) / 2e-4, rel=1e-6)


def test_constraints_that_contradict_each_other_at_an_instant() -> None:
    """Each of the two can be met, but this instant has both readings."""
    system = coupled_system(3)
    first, second, _ = system.model.reading_names
    model = system.model.constrained(lambda x: x[0] + 1, needs=[first])
    model = model.constrained(lambda x: 1 - x[0], needs=[second])
    rng = np.random.default_rng(0)
    measurements = system.simulate(0.1 * np.arange(N_STAGES), rng, missing=0.0)
    window, osqp = linearised(model, measurements, seed=1), OsqpWindow(model, N_STAGES)
    found = run(window, osqp)
    assert (found.status, found.solved) == (Status.INFEASIBLE, False)
    assert not found.d.any()
    assert not found.multipliers.any()
    assert np.array_equal(found.w, window.view.w)
    apart = [
        Measurement(m.time_s, np.where([k % 2, 1 - k % 2, 1], m.y, np.nan))
        for k, m in enumerate(measurements)
    ]
    again = linearised(model, apart, seed=1)
    found, fresh = run(again, osqp), run(again, OsqpWindow(model, N_STAGES))
    assert found.solved
    assert fresh.solved
    assert found.d == pytest.approx(fresh.d, abs=1e-9)


def test_one_stage() -> None:
    model, measurements = bounded_stream(1)
    window = linearised(model, measurements, seed=0)
    found = run(window, OsqpWindow(model, 1))
    wanted = WindowPass(model, MheConfig(horizon=1)).run(window.view, window.d, window.scales)
    assert found.d == pytest.approx(wanted.d, abs=1e-9)
    assert found.w.shape == (0, model.n_w)


def test_another_length_is_refused() -> None:
    model, measurements = bounded_stream(4)
    with pytest.raises(InputError, match="a window of 4 stages, expected 5"):
        run(linearised(model, measurements, seed=0), OsqpWindow(model, 5))


def test_a_prior_without_a_factor_and_absurd_readings_say_so() -> None:
    model, measurements = bounded_stream(4)
    osqp = OsqpWindow(model, 4)
    window = linearised(model, measurements, seed=0)
    window.view.prior.covariance[:] = -np.eye(model.n_x)
    assert run(window, osqp).status is Status.NOT_FINITE
    window = linearised(model, measurements, seed=0)
    window.view.y[2] = 1e308  # over its standard deviation: infinite
    assert run(window, osqp).status is Status.NOT_FINITE
    assert run(linearised(model, measurements, seed=0), osqp).solved


@pytest.mark.parametrize("is_first", [True, False])
def test_readings_beyond_osqps_infinity_say_so(is_first: bool) -> None:
    """Set up with them it raised; handed over to it, it kept the numbers of the window before."""
    model, measurements = bounded_stream(4)
    osqp = OsqpWindow(model, 4)
    if not is_first:
        assert run(linearised(model, measurements, seed=0), osqp).solved
    window = linearised(model, measurements, seed=0)
    window.view.y[2] = 1e35
    assert run(window, osqp).status is Status.NOT_FINITE
    assert run(linearised(model, measurements, seed=0), osqp).solved


def test_the_prior_may_say_nothing() -> None:
    """Deviations a million times as large: readings alone hold the window."""
    system = constant_acceleration_system(1)
    rng = np.random.default_rng(5)
    measurements = system.simulate(0.1 * np.arange(N_STAGES), rng, missing=0.0)
    wide = GaussianState(system.model.prior.mean, 1e12 * system.model.prior.covariance)
    problem = linear_batch(system, measurements, covariance=wide.covariance)
    limit = float(np.median(problem.solve().states[:, 0]))
    model = system.model.replace(prior=wide).bounded(s0_m=(-np.inf, limit))
    window = linearised(model, measurements, seed=0, off=1e-6)
    C = np.eye(1, model.n_x)
    wanted = solve_held(problem, C, np.array([limit]), window.demanded)
    found = run(window, OsqpWindow(model, N_STAGES))
    assert found.solved
    assert (wanted.multipliers > 0).any()
    assert np.abs((window.view.x + found.d - wanted.states) / wanted.std).max() < TOLERANCE
