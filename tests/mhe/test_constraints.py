"""Active bounds and inequalities: the window's optimum is SciPy's."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.configs import config_for
from tests.estimation import pens
from tests.linear_models import LinearSystem, constant_acceleration_system, coupled_system
from tests.mhe.runs import CONVERGING, ESTIMATORS, ON_A_PEN, full_length, linear_batch, run_mhe
from tests.references.constrained import ConstrainedSolution, solve_constrained

SLOW = pytest.mark.slow
TOLERANCE = 1e-6
N_STAGES = 10


def precise(system: LinearSystem) -> LinearSystem:
    """The same system with sensors a hundred times better: strong conflicts with the bounds."""
    sensors = tuple(
        dataclasses.replace(s, noise_std=s.noise_std / 100) for s in system.model.sensors
    )
    model = system.model.replace(sensors=sensors)
    return dataclasses.replace(system, model=model, R=system.R / 100**2)


# name → system, seed, stages at which at least one bound and the inequality are active
LINEAR = {
    "one axis, bound at many stages": (constant_acceleration_system(1), 4, 9, 0),
    "one axis, inequality at many stages": (constant_acceleration_system(1), 1, 1, 9),
    "one axis, weakly active": (constant_acceleration_system(1), 2, 2, 1),
    "two axes": (constant_acceleration_system(2), 1, 1, 4),
    "coupled": (coupled_system(3), 2, 3, 5),
    "coupled, precise sensors": (precise(coupled_system(5)), 0, 0, 2),
    "two axes, precise sensors": (precise(constant_acceleration_system(2)), 2, 6, 8),
    "two axes, precise, nearly degenerate": (precise(constant_acceleration_system(2)), 1, 5, 7),
    "coupled, precise, many active": (precise(coupled_system(3)), 2, 3, 6),
    "one axis, precise sensors": (precise(constant_acceleration_system(1)), 0, 8, 0),
}


def constrained_case(
    system: LinearSystem, measurements: list[Measurement]
) -> tuple[StateSpaceModel, Array, Array]:
    """Bounds through the middle of the free solution, and s0 + s2 <= c; also as C x <= d."""
    states = linear_batch(system, measurements).solve().states
    high, low = np.median(states[:, 0]), np.median(states[:, 1])
    total = np.median(states[:, 0] + states[:, 2])
    model = system.model.bounded(s0_m=(-np.inf, high), s1_m=(low, np.inf)).constrained(
        lambda x: x[0] + x[2] - total
    )
    C = np.zeros((3, system.model.n_x))
    C[0, 0], C[1, 1], C[2, [0, 2]] = 1, -1, 1
    return model, C, np.array([high, -low, total])


def stricter_error(states: Array, wanted: Array, std: Array) -> float:
    """Largest error in state units or standard deviations, whichever is larger."""
    error = np.abs(states - wanted)
    return float(np.maximum(error, error / std).max())


@dataclasses.dataclass(frozen=True, eq=False)
class GrowingWindow:
    """Readings, the model with C x <= d, and the optimum (number of stages → it)."""

    measurements: list[Measurement]
    model: StateSpaceModel
    C: Array
    d: Array
    wanted: dict[int, ConstrainedSolution]


@cache
def linear_window(name: str) -> GrowingWindow:
    system, seed, *_ = LINEAR[name]
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.05, 0.2, N_STAGES))
    measurements = system.simulate(times, rng, missing=0.2)
    model, C, d = constrained_case(system, measurements)
    wanted = {
        n: solve_constrained(linear_batch(system, measurements[:n]), C, d)
        for n in range(1, N_STAGES + 1)
    }
    return GrowingWindow(measurements, model, C, d, wanted)


@cache
def pen_window(seed: int) -> GrowingWindow:
    """tip_z >= c at several stages, and tip_x + tip_y <= c."""
    run = pens.draw_pen_run(N_STAGES, seed)
    free = pens.pen_batch(run.measurements).solve().states
    desk, wall = np.quantile(free[:, 2], 0.6), np.quantile(free[:, 0] + free[:, 1], 0.4)
    model = run.model.bounded(tip_z_m=(desk, np.inf)).constrained(lambda x: x[0] + x[1] - wall)
    C, d = np.zeros((2, 15)), np.array([-desk, wall])
    C[0, 2], C[1, :2] = -1, 1
    wanted = {
        n: solve_constrained(pens.pen_batch(run.measurements[:n]), C, d)
        for n in (1, 2, 3, 5, 8, N_STAGES)
    }
    return GrowingWindow(run.measurements, model, C, d, wanted)


QUICK = (
    "one axis, bound at many stages",
    "one axis, weakly active",
    "coupled",
    "two axes, precise, nearly degenerate",
    "coupled, precise, many active",
)
"""What quick tests give to IPOPT; to the estimator that iterates they give all."""


@pytest.mark.parametrize(
    ("name", "estimator"),
    [
        pytest.param(name, estimator, marks=() if estimator == "mhe" or name in QUICK else SLOW)
        for name in LINEAR
        for estimator in CONVERGING
    ],
)
def test_linear_windows_while_they_grow(name: str, estimator: str) -> None:
    _, _, with_bound, with_inequality = LINEAR[name]
    case = linear_window(name)
    config = config_for(estimator, horizon=N_STAGES - 1)
    estimates = run_mhe(case.model, case.measurements, config, estimator)
    for k, estimate in enumerate(estimates):
        wanted = case.wanted[k + 1]
        assert estimate.window is not None
        assert estimate.status.is_solved
        error = stricter_error(estimate.window.states, wanted.states, wanted.std)
        assert error < TOLERANCE, f"window of {k + 1} stages"
        assert (estimate.window.states @ case.C.T <= case.d + 1e-8).all()
    assert wanted.active[:, :2].any(axis=1).sum() >= with_bound
    assert wanted.active[:, 2].sum() >= with_inequality
    assert not wanted.active.all()


@pytest.mark.parametrize("estimator", ON_A_PEN)
@pytest.mark.parametrize("seed", [*(pytest.param(n, marks=SLOW) for n in (0, 4)), 1])
def test_pen_above_its_desk_and_beside_a_wall(seed: int, estimator: str) -> None:
    """On the nonlinear pen."""
    case = pen_window(seed)
    config = config_for(estimator, horizon=full_length(case.measurements))
    mhe = ESTIMATORS[estimator](case.model, config)
    state, errors = mhe.init(), []
    for n, measurement in enumerate(case.measurements, 1):
        state, estimate = mhe.step(state, measurement)
        assert estimate.window is not None
        assert estimate.status is Status.SOLVED
        if n in case.wanted:
            wanted = case.wanted[n]
            errors.append(stricter_error(estimate.window.states, wanted.states, wanted.std))
    assert len(errors) == len(case.wanted)
    assert max(errors) < TOLERANCE
    assert wanted.active.any()


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_bounds_that_are_far_away_change_nothing(estimator: str) -> None:
    system, rng = coupled_system(3), np.random.default_rng(2)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, 8)), rng)
    config = config_for(estimator, horizon=4, tolerance=1e-10)
    free = run_mhe(system.model, measurements, config, estimator)
    far = system.model.bounded(s0_m=(-1e3, 1e3)).constrained(lambda x: x[1] - 1e3)
    for one, other in zip(free, run_mhe(far, measurements, config, estimator), strict=True):
        assert np.abs((one.state.mean - other.state.mean) / one.state.std).max() < TOLERANCE


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_bound_outlives_the_stage_that_carried_it(estimator: str) -> None:
    """A sliding window: every newest estimate obeys, also long after the first windows."""
    system, rng = constant_acceleration_system(1), np.random.default_rng(6)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, 30)), rng, missing=0.0)
    level = float(np.median([m.y[0] for m in measurements]))
    model = system.model.bounded(s0_m=(-np.inf, level))
    estimates = run_mhe(model, measurements, config_for(estimator, horizon=4), estimator)
    free = run_mhe(system.model, measurements, config_for(estimator, horizon=4), estimator)
    newest = np.array([estimate.state.mean[0] for estimate in estimates])
    assert sum(estimate.state.mean[0] > level for estimate in free) > 5
    assert (newest <= level + 1e-8).all()
    assert all(estimate.status.is_solved for estimate in estimates)
