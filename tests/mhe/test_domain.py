"""A model that is not defined beyond its bound: a tank whose outflow reads √x, and x ≥ 1e-4."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from estimation.estimator import run_measurements
from estimation.recording import Measurement
from models.arrays import Array
from models.own_models import OwnSensor, own_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator

STEP_S, LOWEST, NOISE_STD, WALK, HORIZON = 0.1, 1e-4, 0.05, 0.02, 10
"""Of problem ``tank`` of the suite of classics."""


def tank() -> StateSpaceModel:
    return own_model(
        "tank",
        {"level_m": (0.3, 0.3)},
        lambda x, w, dt: x + WALK * ca.sqrt(dt) * w,
        1,
        {"flow": OwnSensor(lambda x: ca.sqrt(x[0]), {"x": "m"}, NOISE_STD)},
        bounds={"level_m": (LOWEST, None)},
    )


def drawn(samples: int, seed: int) -> tuple[list[Measurement], Array]:
    """Return readings and true levels, which are drawn again where they leave the domain."""
    rng, level, levels, readings = np.random.default_rng(seed), 0.01, list[float](), []
    for k in range(samples):
        levels.append(level)
        readings.append(
            Measurement(STEP_S * k, np.sqrt([level]) + NOISE_STD * rng.standard_normal(1))
        )
        step = np.inf
        while not level + step >= LOWEST or not np.isfinite(step):
            step = WALK * np.sqrt(STEP_S) * rng.standard_normal()
        level += step
    return readings, np.array(levels)


@pytest.mark.parametrize(
    ("name", "samples", "seeds"),
    [("mhe", 300, 5), ("mhe-rti", 300, 5), ("mhe-ipopt", 60, 2)],
)
def test_no_step_leaves_the_domain(name: str, samples: int, seeds: int) -> None:
    estimator = create_estimator(name, tank(), horizon=HORIZON)
    for seed in range(seeds):
        measurements, levels = drawn(samples, seed)
        history = run_measurements(estimator, measurements)
        assert all(status.is_solved for status in history.status)
        assert (history.mean[:, 0] >= LOWEST * (1 - 1e-9)).all()
        error = np.abs(history.mean[:, 0] - levels)
        assert (error <= 3 * history.std[:, 0]).mean() >= 0.95


@pytest.mark.cover
@pytest.mark.parametrize("arrival_cost", ["filtered", "smoothed"])
@pytest.mark.parametrize("name", ["mhe", "mhe-rti", "mhe-ipopt"])
def test_an_absurd_reading_is_not_for_good(name: str, arrival_cost: str) -> None:
    """Also behind an EKF's prior, whose mean may lie outside the domain."""
    estimator = create_estimator(name, tank(), horizon=3, arrival_cost=arrival_cost)
    measurements, levels = drawn(60, 1)
    measurements[20] = replace(measurements[20], y=np.array([1e200]))
    history = run_measurements(estimator, measurements)
    assert np.isfinite(history.mean).all()
    assert np.isfinite(history.std).all()
    assert not history.status[20].is_solved
    error = np.abs(history.mean[30:, 0] - levels[30:])
    assert (error <= 3 * history.std[30:, 0]).mean() >= 0.9


def test_a_kalman_filter_has_no_bound_and_says_so() -> None:
    """The test's own test: without the bound the same readings end outside the domain."""
    history = run_measurements(create_estimator("ekf", tank()), drawn(300, 0)[0])
    assert (history.mean[:, 0] < LOWEST).any()
