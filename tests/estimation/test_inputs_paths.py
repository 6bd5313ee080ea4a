"""Known inputs on every other path: bounds and losses, IPOPT and OSQP, deadlines, observability."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from estimation.estimator import run
from estimation.inputs import all_with_inputs
from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement, Recording
from estimation.status import Status
from mhe.config import MheConfig, MheIpoptConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from mhe.reference.ipopt import MheIpopt
from mhe.sparse_qp.sequential_qp import SequentialQp
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.linear_models import linear_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from pen_mhe.sensor_verdict import judge
from recordings.simulate_pen import simulate_model
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation.lamps import lamp, swung

LIMIT = 0.62
NONE = 1e9
"""A threshold of Huber's loss that nothing reaches."""
N = 7
LOSSES: dict[str, Any] = {"huber": {"shadow": 1.0}, "sparse_noise": 0.5}


@pytest.fixture(scope="module")
def swing() -> Recording:
    """One shadow is far off, which a loss forgives."""
    found = swung()
    shadow = found.readings["shadow"].copy()
    shadow[4] += 0.2
    readings = {**found.readings, "shadow": shadow}
    return Recording("swing", found.time_s, readings, found.truth, found.inputs)


@pytest.fixture(params=["compiled", pytest.param("interpreted", marks=pytest.mark.slow)])
def engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


def bounded() -> StateSpaceModel:
    return lamp().bounded(rate_rad_s=(-np.inf, LIMIT))


def huber(length: Array, threshold: float) -> float:
    beyond = threshold * length - threshold**2 / 2
    return float(np.where(length <= threshold, length**2 / 2, beyond).sum())


def rolled_out(z: Array, rows: tuple[Measurement, ...]) -> Array:
    """Return the states (n, 2) of the lamp's own equation, written out again."""
    x = [np.array([0.4, 0.0]) + np.array([0.3, 0.5]) * z[:2]]
    for (here, there), w in zip(itertools.pairwise(rows), z[2:], strict=True):
        dt, torque = there.time_s - here.time_s, (here.y[2] + there.y[2]) / 2
        pull = torque - 9.0 * np.sin(x[-1][0]) - 0.3 * x[-1][1]
        rate = x[-1][1] + dt * pull + 0.5 * np.sqrt(dt) * w
        x.append(np.array([x[-1][0] + dt * x[-1][1], rate]))
    return np.array(x)


def scipys(
    rows: tuple[Measurement, ...], losses: dict[str, Any], limit: float
) -> tuple[Array, float]:
    """Return states and cost of the window's optimum by sequential quadratic programming."""
    y = np.array([row.y for row in rows])
    shadow_k = losses.get("huber", {}).get("shadow", NONE)
    noise_k = losses.get("sparse_noise", NONE)

    def cost(z: Array) -> float:
        x = rolled_out(z, rows)
        shadow = np.abs(y[:, 0] - y[:, 3] * np.sin(x[:, 0])) / 0.01
        turns = np.abs(y[:, 1] - x[:, 1]) / 0.2
        read = huber(shadow[np.isfinite(shadow)], shadow_k) + np.nansum(turns**2) / 2
        return float(z[:2] @ z[:2]) / 2 + huber(np.abs(z[2:]), noise_k) + read

    constraint = {"type": "ineq", "fun": lambda z: limit - rolled_out(z, rows)[:, 1]}
    best = minimize(
        cost, np.zeros(len(rows) + 1), method="SLSQP", jac="3-point",
        constraints=[constraint] if np.isfinite(limit) else [],
        options={"ftol": 1e-14, "maxiter": 500},
    )  # fmt: skip
    return rolled_out(best.x, rows), float(best.fun)


CASES = {
    "bounds": (bounded, {}, LIMIT),
    "losses": (lamp, LOSSES, np.inf),
    "both": (bounded, LOSSES, LIMIT),
}


@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("solver", [Mhe, MheIpopt, SequentialQp])
@pytest.mark.parametrize("case", CASES)
def test_windows_with_bounds_and_losses_are_scipys(
    swing: Recording, solver: Any, case: str
) -> None:
    build, losses, limit = CASES[case]
    model: StateSpaceModel = build()
    rows = all_with_inputs(model, list(swing.measurements(model))[:N])
    wanted, cost = scipys(rows, losses, limit)
    assert case == "losses" or (wanted[:, 1] > LIMIT - 1e-6).any()
    config = (MheIpoptConfig if solver is MheIpopt else MheConfig)(horizon=10, **losses)
    start = np.array([0.4, 0.0])
    guess = Trajectory(np.tile(start, (N, 1)), np.zeros((N - 1, 1)))
    found = solver(model, config).solve(model.prior, rows, guess)
    assert found.cost == pytest.approx(cost, rel=1e-6)
    np.testing.assert_allclose(found.trajectory.states, wanted, rtol=0, atol=2e-4)


@needs_compiler
@pytest.mark.parametrize("name", ["mhe-rti", pytest.param("mhe", marks=pytest.mark.slow)])
@pytest.mark.parametrize("case", CASES)
def test_compiled_is_interpreted(swing: Recording, name: str, case: str) -> None:
    build, losses, _ = CASES[case]
    model: StateSpaceModel = build()
    both = compiled_and_interpreted(lambda: create_estimator(name, model, horizon=4, **losses))
    stream = list(swing.measurements(model))
    ours, theirs = (steps(estimator, stream) for estimator in both)
    tolerance = 1e-7 if name == "mhe" else 1e-12
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(one.state.mean, other.state.mean, rtol=tolerance)
        np.testing.assert_allclose(one.state.covariance, other.state.covariance, rtol=tolerance)
        assert one.status == other.status
    if case != "losses":
        assert max(e.state.mean[1] for e in ours) > LIMIT - 1e-6


class Clock:
    """Goes on by `tick` seconds whenever it is read."""

    def __init__(self) -> None:
        self.tick, self.time_s = 1e-9, 0.0

    def __call__(self) -> float:
        self.time_s += self.tick
        return self.time_s


@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("kind", [MheRti, Mhe])
def test_without_time_the_known_torque_is_in_the_prediction(swing: Recording, kind: Any) -> None:
    """And the step behind it knows its inputs, the held gain included."""
    model, clock = lamp(), Clock()
    config = MheConfig if kind is Mhe else MheRtiConfig
    mhe = kind(model, config(horizon=4, deadline_s=1.0), clock=clock)
    *before, late, after = list(swing.measurements(model))[:9]
    state = mhe.init()
    for measurement in before:
        state, estimate = mhe.step(state, measurement)
    clock.tick = 10.0
    state, predicted = mhe.step(state, late)
    assert Status.PREDICTED in predicted.status
    dt = late.time_s - before[-1].time_s
    ends = model.step_inputs(before[-1].y, late.y)
    wanted = KalmanStage(model).predict(estimate.state, dt, inputs=ends).state
    np.testing.assert_allclose(predicted.state.mean, wanted.mean, rtol=1e-9)
    np.testing.assert_allclose(predicted.state.covariance, wanted.covariance, rtol=1e-9)
    clock.tick = 1e-9
    row = after.y.copy()
    row[model.n_y + 1] = np.nan
    _, told = mhe.step(state, after)
    _, held = mhe.step(state, Measurement(after.time_s, row))
    np.testing.assert_array_equal(told.state.mean, held.state.mean)


@pytest.mark.usefixtures("interpreted")
def test_ipopt_out_of_time_rolls_out_with_the_known_torque(swing: Recording) -> None:
    """Its best of two is one that obeys f, inputs and all."""
    model = lamp()
    mhe = MheIpopt(model, MheIpoptConfig(horizon=4, deadline_s=1e-9))
    state = mhe.init()
    for measurement in list(swing.measurements(model))[:6]:
        state, estimate = mhe.step(state, measurement)
    assert Status.TIME_LIMIT in estimate.status
    assert state.trajectory is not None
    pairs = zip(itertools.pairwise(state.measurements), state.trajectory.noises, strict=True)
    for k, ((here, there), w) in enumerate(pairs):
        dt, ends = there.time_s - here.time_s, model.step_inputs(here.y, there.y)
        after = model.f(state.trajectory.states[k], w, dt, *ends).full().ravel()
        np.testing.assert_allclose(after, state.trajectory.states[k + 1], rtol=1e-12)


@pytest.mark.usefixtures("interpreted")
def test_a_gain_of_zero_shows_nothing(swing: Recording) -> None:
    """What a sensor can see depends on the inputs that it reads with."""
    shadow = lamp().replace(sensors=lamp().sensors[:1])
    assert judge(shadow, swing).observability.rank == 2
    dark = Recording(
        "dark",
        swing.time_s,
        swing.readings,
        swing.truth,
        {**swing.inputs, "gain": 0 * swing.time_s},
    )
    found = judge(shadow, dark)
    assert found.observability.rank == 0
    assert not found.sees("angle_rad")


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("dt_s", [None, 0.1])
def test_the_bound_of_a_pushed_cart_is_the_filters(dt_s: float | None) -> None:
    """A known force moves the mean and not what can be known."""
    A = np.array([[0, 1.0], [0, 0]]) if dt_s is None else np.array([[1, 0.1], [0, 1.0]])
    model = linear_model(
        "cart", A, [1, 0], G=[0, 0.3], R=0.01, B=[0, 1], prior=(0, 1), dt_s=dt_s, rate_hz=10
    )
    recording = simulate_model(model, duration_s=1.0, inputs={"u1": np.cos})
    found, history = judge(model, recording), run(create_estimator("ekf", model), recording)
    assert found.observability.rank == 2
    np.testing.assert_allclose(found.bound.std[-1], history.std[-1], rtol=1e-9)
