"""Minima on bounds: a second start leaves them, and an improbable window says that it is one."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest
from scipy.stats import chi2

from benchmark.configurations import CONFIGURATIONS
from estimation.estimate import Estimate
from estimation.estimator import run, run_measurements
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig
from mhe.realtime import Mhe
from mhe.second_start import cost_limits
from models.arrays import Array
from models.own_models import OwnSensor, own_model
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate
from tests.closeness import estimate_error
from tests.configs import config_for
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.linear_models import constant_acceleration_system
from tests.mhe.runs import ESTIMATORS, run_mhe
from tests.mhe.test_domain import tank

K, STEP_S, READING_STD, HORIZON = 0.16, 0.1, 0.1, 10
"""Two reactions of Haseltine and Rawlings (2005), 2A → B: d/dt (pa, pb) = (-2k, k) pa²."""
TRUTH, PRIOR_MEAN, PRIOR_STD, WALK = (3.0, 1.0), (0.1, 4.5), 6.0, 0.001


def gas() -> StateSpaceModel:
    def rate(x: ca.SX) -> ca.SX:
        return K * x[0] ** 2 * ca.DM([-2, 1])

    def transition(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
        half = x + dt / 2 * rate(x)
        return x + dt * rate(half) + WALK * ca.sqrt(dt / STEP_S) * w

    names = ("pa", "pb")
    return own_model(
        "2A to B",
        {name: (mean, PRIOR_STD) for name, mean in zip(names, PRIOR_MEAN, strict=True)},
        transition,
        2,
        {"gauge": OwnSensor(lambda x: x[0] + x[1], {"p": "m"}, READING_STD)},
        bounds=dict.fromkeys(names, (0.0, None)),
    )


def pressures(pa: Array, pb: Array, samples: int) -> list[Array]:
    """Return pa + pb over time, without noise, of first states (n,); typed independently."""
    found = []
    for _ in range(samples):
        found.append(pa + pb)
        middle = pa - STEP_S * K * pa**2
        pa, pb = pa - 2 * STEP_S * K * middle**2, pb + STEP_S * K * middle**2
    return found


def readings(seed: int, samples: int) -> list[Measurement]:
    rng = np.random.default_rng(seed)
    exact = pressures(*np.array(TRUTH)[:, None], samples)
    return [
        Measurement(STEP_S * k, p + READING_STD * rng.standard_normal(1))
        for k, p in enumerate(exact)
    ]


def lowest_on_a_grid(measurements: list[Measurement]) -> float:
    """Return the least cost of trajectories without noise from first states on a grid."""
    fine = np.linspace(0, 8, 161)
    pa, pb = (axis.ravel() for axis in np.meshgrid(fine, fine))
    squares = sum(
        ((value - mean) / PRIOR_STD) ** 2 for value, mean in zip((pa, pb), PRIOR_MEAN, strict=True)
    )
    expected = pressures(pa, pb, len(measurements))
    for at, measurement in zip(expected, measurements, strict=True):
        squares = squares + ((measurement.y[0] - at) / READING_STD) ** 2
    return float(np.min(squares)) / 2


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("seed", [0, 1])
def test_the_lower_minimum_from_the_first_windows_on(seed: int) -> None:
    """On P_A = 0, where the first reading drives the estimate, no derivative leads away."""
    measurements = readings(seed, HORIZON + 1)
    mhe = Mhe(gas(), MheConfig(horizon=HORIZON))
    state = mhe.init()
    for k, measurement in enumerate(measurements):
        state, estimate = mhe.step(state, measurement)
        assert estimate.status is Status.SOLVED
        assert cost_of(mhe, state.memory) <= lowest_on_a_grid(measurements[: k + 1])


def cost_of(mhe: Mhe, memory: Array) -> float:
    """Return the cost of a window, all of whose samples are in it."""
    layout = mhe.engine.memory
    count = int(layout.view(memory, "count"))
    x, w, y = (layout.view(memory, name)[:count] for name in ("x", "w", "y"))
    off = np.concatenate(
        [
            (x[0] - PRIOR_MEAN) / PRIOR_STD,
            w[: count - 1].ravel(),
            (y[:, 0] - x.sum(axis=1)) / READING_STD,
        ]
    )
    return float(off @ off) / 2


@needs_compiler
def test_both_engines_start_alike() -> None:
    measurements = readings(0, 3 * HORIZON)
    measurements[15] = Measurement(measurements[15].time_s, np.array([9.0]))
    model = gas()
    compiled, interpreted = compiled_and_interpreted(lambda: Mhe(model, MheConfig(horizon=5)))
    for a, b in zip(steps(compiled, measurements), steps(interpreted, measurements), strict=True):
        assert a.status is b.status
        assert a.iterations == b.iterations
        assert estimate_error(model, a, b) < 1e-9


def test_the_reference_takes_the_same_minimum() -> None:
    measurements = readings(0, HORIZON + 3)
    ours, reference = (
        run_measurements(create_estimator(name, gas(), horizon=HORIZON), measurements)
        for name in ("mhe", "mhe-ipopt")
    )
    assert np.abs((ours.mean - reference.mean) / reference.std).max() < 1e-5


@pytest.mark.usefixtures("engine")
def test_in_a_full_window_at_most_one_in_n_samples() -> None:
    """A level that stays on its bound: `wait` counts the samples down to the next start."""
    mhe = Mhe(tank(), MheConfig(horizon=4))
    state, waits = mhe.init(), []
    for k in range(20):
        state, _ = mhe.step(state, Measurement(0.1 * k, np.array([-0.3])))
        waits.append(int(mhe.engine.memory.view(state.memory, "wait")))
    assert waits[:4] == [0, 0, 0, 0]
    assert waits[4:] == [4, 3, 2, 1, 0] * 3 + [4]


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", ESTIMATORS)
def test_improbable_is_what_chi_square_says(name: str) -> None:
    """On a linear model twice the cost of a window is the sum of its innovations' squares."""
    system, horizon = constant_acceleration_system(1), 4
    measurements = system.simulate(0.1 * np.arange(14.0), np.random.default_rng(3), missing=0.2)
    measurements[8] = Measurement(measurements[8].time_s, measurements[8].y + 40)
    found = run_mhe(system.model, measurements, config_for(name, horizon=horizon), name)
    parts = [
        (len(p.rows), p.innovation @ np.linalg.solve(p.innovation_covariance, p.innovation))
        for p in system.textbook(measurements)
    ]
    expected = []
    for k in range(len(parts)):
        rows, squares = np.sum(parts[max(k - horizon, 0) : k + 1], axis=0)
        is_judged = rows > 0 and (name != "mhe-rti" or k >= horizon)
        expected.append(is_judged and squares > chi2.isf(1e-6, rows))
    assert [Status.IMPROBABLE in estimate.status for estimate in found] == expected
    assert any(expected)
    assert not any(expected[:8])
    assert all(estimate.status.is_solved for estimate in found)


def test_limits_are_quantiles() -> None:
    """What a χ² variable of so many degrees of freedom exceeds once in a million."""
    limits = cost_limits(3, 2)
    assert limits[0] == np.inf
    assert chi2.sf(2 * limits[1:], np.arange(1, 7)) == pytest.approx(np.full(6, 1e-6), rel=1e-9)


def never_on_a_clean_pen(name: str, estimator: str, seeds: int, duration_s: float) -> None:
    """A pen that writes. One drawn from its model may spin past its sensors' range, and is lost."""
    pen, sensors = load_pen("reference"), CONFIGURATIONS[name].sensors
    mhe = create_estimator(estimator, pen_model(pen, sensors))
    for seed in range(seeds):
        recording = simulate(pen, sensors, motion="handwriting", duration_s=duration_s, seed=seed)
        history = run(mhe, recording)
        assert history.solved_fraction == 1
        assert not any(Status.IMPROBABLE in status for status in history.status)


@pytest.mark.parametrize("name", ["accel", "two accelerometers", "accel+gyro+camera"])
def test_never_on_a_clean_pen(name: str) -> None:
    never_on_a_clean_pen(name, "mhe-rti", seeds=1, duration_s=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["mhe-rti", "mhe"])
@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_never_on_twenty_clean_pens(name: str, estimator: str) -> None:
    never_on_a_clean_pen(name, estimator, seeds=20, duration_s=2.0)


def leaking() -> StateSpaceModel:
    """A tank that a known rate empties: predictions leave the domain, readings do not."""
    return own_model(
        "leak",
        {"level": (0.3, 0.3)},
        lambda x, w, dt: x - 0.5 * dt + 0.3 * ca.sqrt(dt) * w,
        1,
        {"flow": OwnSensor(lambda x: ca.sqrt(x[0]), {"x": "m"}, 0.05)},
        bounds={"level": (1e-4, None)},
    )


@cache
def leak_reference(arrival_cost: str) -> list[Estimate]:
    return leak_estimates("mhe-ipopt", arrival_cost)


def leak_estimates(name: str, arrival_cost: str) -> list[Estimate]:
    rng = np.random.default_rng(5)
    readings = [
        Measurement(
            0.1 * k, np.array([max(0.3 - 0.04 * k, 0.1) ** 0.5]) + 0.05 * rng.normal(size=1)
        )
        for k in range(40)
    ]
    estimator = create_estimator(name, leaking(), horizon=5, arrival_cost=arrival_cost)
    return steps(estimator, readings)


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("arrival_cost", ["smoothed", "filtered"])
def test_a_prediction_beyond_the_bound_is_no_start(arrival_cost: str) -> None:
    """All end where IPOPT ends; before, the first guess was a root of a negative number."""
    reference, model = leak_reference(arrival_cost), leaking()
    for name in ("mhe", "mhe-rti"):
        found = leak_estimates(name, arrival_cost)
        assert all(estimate.status.is_solved for estimate in found)
        assert min(estimate.state.mean[0] for estimate in found) >= 1e-4 * (1 - 1e-9)
        if name == "mhe":
            for a, b in zip(found, reference, strict=True):
                assert estimate_error(model, a, b) < 1e-5
