"""Huber's loss per sensor and on the noises: the optimum is that of the loss itself."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.config import MheConfig
from mhe.realtime import Mhe
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.errors import InputError
from tests.closeness import mean_error
from tests.configs import config_for
from tests.estimation import pens
from tests.linear_models import LinearSystem, coupled_system
from tests.mhe.runs import CONVERGING, ESTIMATORS, REAL_TIME, full_length, linear_batch, run_mhe
from tests.references.batch import BatchProblem
from tests.references.huber import RobustSolution, solve_robust

SYSTEM = coupled_system(3)
ROWS = {"first": [0], "second": [1, 2]}
N = 14
LOSSES: dict[str, dict[str, Any]] = {
    "one row": {"huber": {"first": 1.0}},
    "two rows": {"huber": {"second": 1.5}},
    "both sensors": {"huber": {"first": 0.7, "second": 2.0}},
    "sparse noise": {"sparse_noise": 0.8},
    "all": {"huber": {"first": 1.0, "second": 1.0}, "sparse_noise": 1.0},
}


def readings(outlier: float = 6.0) -> list[Measurement]:
    """A run with one row missing and an outlier in every row."""
    rng = np.random.default_rng(23)
    measurements = SYSTEM.simulate(np.cumsum(rng.uniform(0.05, 0.3, N)), rng, missing=0.0)
    y = np.array([m.y for m in measurements])
    y[3, 0] += outlier
    y[7, 1:] += [outlier, -2 * outlier]
    y[5, 2] = np.nan
    return [Measurement(m.time_s, row) for m, row in zip(measurements, y, strict=True)]


def groups(
    measurements: list[Measurement], settings: dict[str, Any]
) -> tuple[list[Array], list[float]]:
    """Rows of the batch residual (z, readings that are there) that share a loss."""
    n_x, n_w = SYSTEM.model.n_x, SYSTEM.model.n_w
    n_z = n_x + n_w * (len(measurements) - 1)
    sparse = settings.get("sparse_noise", np.inf)
    rows = [np.arange(n_x), *(np.array([i]) for i in range(n_x, n_z))]
    thresholds = [np.inf] + [sparse] * (n_z - n_x)
    at = n_z
    for measurement in measurements:
        for sensor, columns in ROWS.items():
            there = int((~np.isnan(measurement.y[columns])).sum())
            rows.append(np.arange(at, at + there))
            thresholds.append(settings.get("huber", {}).get(sensor, np.inf))
            at += there
    return rows, thresholds


def window(measurements: list[Measurement]) -> BatchProblem:
    """The batch problem in the model's own noises: a loss on them is not that on others."""
    model, zero = SYSTEM.model, np.zeros(4)
    G = [
        np.array([np.asarray(model.f(zero, e, dt)).ravel() for e in np.eye(4)]).T
        for dt in np.diff([m.time_s for m in measurements])
    ]
    return replace(linear_batch(SYSTEM, measurements), G=G)


def optimum(measurements: list[Measurement], settings: dict[str, Any]) -> RobustSolution:
    return solve_robust(window(measurements), *groups(measurements, settings))


@pytest.mark.parametrize("name", LOSSES)
def test_the_optimum_is_that_of_the_loss(name: str) -> None:
    measurements, settings = readings(), LOSSES[name]
    wanted = optimum(measurements, settings)
    std = linear_batch(SYSTEM, measurements).solve().std
    assert 1 <= wanted.beyond.sum() < len(wanted.beyond) - 5
    for estimator in CONVERGING:
        config = config_for(estimator, horizon=full_length(measurements), **settings)
        estimate = run_mhe(SYSTEM.model, measurements, config, estimator)[-1]
        assert estimate.window is not None
        assert estimate.status.is_solved
        assert np.abs((estimate.window.states - wanted.states) / std).max() < 1e-6, estimator


@pytest.mark.parametrize("name", LOSSES)
def test_the_cost_that_is_told_is_the_loss(name: str) -> None:
    measurements, settings = readings(), LOSSES[name]
    wanted = optimum(measurements, settings)
    batch = window(measurements)
    start = batch.states(np.zeros(batch.n_z))
    mhe = Mhe(SYSTEM.model, MheConfig(horizon=full_length(measurements), **settings))
    noises = np.zeros((N - 1, SYSTEM.model.n_w))
    found = mhe.solve(SYSTEM.model.prior, tuple(measurements), Trajectory(start, noises))
    assert found.cost == pytest.approx(wanted.cost, rel=1e-9)


def newest(system: LinearSystem, outlier: float, estimator: str, **settings: Any) -> Array:
    measurements = readings()
    y = measurements[9].y.copy()
    y[0] += outlier
    measurements[9] = Measurement(measurements[9].time_s, y)
    config = config_for(estimator, horizon=full_length(measurements), **settings)
    return run_mhe(system.model, measurements, config, estimator)[-1].state.mean


@pytest.mark.parametrize("estimator", [pytest.param("mhe-ipopt", marks=pytest.mark.slow), "mhe"])
def test_an_outliers_pull_is_bounded(estimator: str) -> None:
    """Beyond the threshold the slope of the loss is constant: how far off does not matter."""
    huber = {"first": 1.5}
    std = linear_batch(SYSTEM, readings()).solve().std[-1]
    clean, far, farther = (newest(SYSTEM, o, estimator, huber=huber) for o in (0, 1e2, 1e3))
    assert np.abs((farther - far) / std).max() < 1e-6
    assert np.abs((far - clean) / std).max() < 1.0
    pulled = [newest(SYSTEM, o, estimator) - newest(SYSTEM, 0, estimator) for o in (1e2, 1e3)]
    assert np.abs(pulled[0] / std).max() > 5.0
    np.testing.assert_allclose(pulled[1], 10 * pulled[0], rtol=1e-5)


@pytest.mark.parametrize("estimator", CONVERGING)
def test_an_outliers_innovation_is_told_in_full(estimator: str) -> None:
    """Its weighed share would read as a fair prediction and flatter consistency statistics."""
    told = []
    for outlier in (1e2, 1e3):
        measurements = readings()
        measurements[-1].y[0] += outlier
        config = config_for(estimator, horizon=full_length(measurements), huber={"first": 1.5})
        told.append(run_mhe(SYSTEM.model, measurements, config, estimator)[-1])
    one, other = told
    np.testing.assert_allclose(other.innovation - one.innovation, [900, 0, 0], atol=1e-4)
    assert np.abs(one.innovation[0] - 100) < 10
    S, H = one.innovation_covariance, SYSTEM.H
    np.testing.assert_allclose(other.innovation_covariance, S, rtol=1e-4)
    remainder = S - H @ one.state.covariance @ H.T - SYSTEM.R
    assert np.linalg.eigvalsh(remainder).min() > -1e-9, "the prediction knows more than the update"


@pytest.mark.parametrize("estimator", REAL_TIME)
def test_a_threshold_that_nothing_reaches_is_least_squares(estimator: str) -> None:
    run = pens.draw_pen_run(14, seed=5)
    huber = {"accel": 1e6, "gyro": 1e6, "camera": 1e6}
    far, plain = (
        config_for(estimator, horizon=6, huber=huber, sparse_noise=1e6),
        config_for(estimator, horizon=6, reuse_threshold=0.0),
    )
    losses, plain = (
        run_mhe(run.model, run.measurements, config, estimator) for config in (far, plain)
    )
    for one, other in zip(losses, plain, strict=True):
        np.testing.assert_array_equal(one.state.mean, other.state.mean)
        np.testing.assert_array_equal(one.state.covariance, other.state.covariance)
        assert one.iterations == other.iterations


@pytest.mark.parametrize(
    "settings",
    [{"huber": {"camera": 1.0}}, pytest.param({"sparse_noise": 0.3}, marks=pytest.mark.slow)],
)
def test_the_pens_optimum_is_ipopts(settings: dict[str, Any]) -> None:
    run = pens.draw_pen_run(10, seed=5)
    run.measurements[7].y[6] += 0.05  # 25 standard deviations of the camera's position
    tight = {"horizon": full_length(run.measurements), "tolerance": 1e-9, **settings}
    one, other = (
        run_mhe(run.model, run.measurements, config_for(e, **tight), e)[-1] for e in CONVERGING
    )
    plain = run_mhe(run.model, run.measurements, MheConfig(horizon=9), "mhe")[-1]
    assert one.status.is_solved
    assert other.status.is_solved
    assert mean_error(run.model, one.state.mean, other.state) < 1e-5
    assert mean_error(run.model, plain.state.mean, other.state) > 0.1, "the loss did nothing"


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_an_unknown_sensor_is_refused(estimator: str) -> None:
    with pytest.raises(InputError, match=r"sensor third, which is not part.*of first, second"):
        ESTIMATORS[estimator](SYSTEM.model, config_for(estimator, huber={"third": 1.0}))


@pytest.mark.parametrize("threshold", [0.0, -1.0, np.nan])
def test_a_threshold_must_be_positive(threshold: float) -> None:
    with pytest.raises(InputError, match="loss on first, expected a positive"):
        MheConfig(huber={"first": threshold})
    with pytest.raises(InputError, match="loss on sparse_noise, expected a positive"):
        MheConfig(sparse_noise=threshold)
