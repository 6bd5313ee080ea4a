"""NEES and NIS: exact on linear models, where the filter is the conditional distribution."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.consistency import PROBABILITY, consistency_of, nees, nis
from estimation.covariances import Covariances
from estimation.estimator import run_measurements
from estimation.history import EstimateHistory
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from models.arrays import Array
from models.errors import InputError
from models.pen import pen_model
from models.sensor_kinds.gyroscope import Gyroscope
from models.state_space import StateSpaceModel
from tests.linear_models import LinearSystem, coupled_system
from tests.models.pens import GYROSCOPE, pen

pytestmark = pytest.mark.usefixtures("interpreted")

SYSTEM = coupled_system(3)
ALLOWED_ERRORS = 2.6
"""Standard errors: fixed seeds, and a correct filter is outside in 1 of 100 choices of them."""


@dataclass(frozen=True, eq=False)
class Draw:
    """A trajectory drawn from a linear system: truth (n, n_x) and what was measured of it."""

    states: Array
    measurements: list[Measurement]


def draw(system: LinearSystem, n: int, seed: int, missing: float = 0.3) -> Draw:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.02, 0.2, n))
    prior, n_x = system.model.prior, system.model.n_x
    x = prior.mean + np.linalg.cholesky(prior.covariance) @ rng.standard_normal(n_x)
    states = [x]
    for dt in np.diff(times):
        x = system.F(dt) @ x + np.linalg.cholesky(system.Q(dt)) @ rng.standard_normal(n_x)
        states.append(x)
    noise = rng.standard_normal((n, len(system.H))) * np.sqrt(np.diag(system.R))
    y = np.array(states) @ system.H.T + noise
    y[rng.uniform(size=y.shape) < missing] = np.nan
    measurements = [Measurement(float(t), row) for t, row in zip(times, y, strict=True)]
    return Draw(np.array(states), measurements)


def noisier(model: StateSpaceModel, factor: float) -> StateSpaceModel:
    """Return a model that takes the variance of every reading for `factor` times as large."""
    sensors = tuple(replace(s, noise_std=np.sqrt(factor) * s.noise_std) for s in model.sensors)
    return model.replace(sensors=sensors)


def assert_mean(per_run: Array, expected: float) -> None:
    """Runs are independent: their mean is within some standard errors of what is expected."""
    standard_error = per_run.std(ddof=1) / np.sqrt(len(per_run))
    assert abs(per_run.mean() - expected) < ALLOWED_ERRORS * standard_error
    assert standard_error < 0.1 * expected  # or nothing would be shown


def test_a_kalman_filter_is_consistent() -> None:
    ekf, n_runs = Ekf(SYSTEM.model), 60
    error_means, newest, innovations, freedoms = [], [], [], []
    for seed in range(n_runs):
        run = draw(SYSTEM, 25, seed)
        history = run_measurements(ekf, run.measurements, covariances=True)
        squared = nees(SYSTEM.model, history, run.states)
        error_means.append(squared.mean())
        newest.append(squared[-1])
        squared, freedom = nis(history)
        innovations.append(squared)
        freedoms.append(freedom)
    assert_mean(np.array(error_means), SYSTEM.model.n_x)
    # The last instants of the runs are independent: χ² holds exactly.
    last = consistency_of(np.array(newest), SYSTEM.model.n_x)
    assert (last.count, last.expected) == (n_runs, SYSTEM.model.n_x)
    assert last.is_inside
    # Innovations are independent within a run, too.
    white = consistency_of(np.concatenate(innovations), np.concatenate(freedoms))
    assert white.is_inside
    assert white.count > 1400
    assert white.inside_fraction == pytest.approx(
        PROBABILITY, abs=ALLOWED_ERRORS * np.sqrt(PROBABILITY * (1 - PROBABILITY) / white.count)
    )


def test_an_mhe_is_consistent() -> None:
    """With a short horizon, too: on a linear model its statistics are the Kalman filter's."""
    mhe, ekf = MheIpopt(SYSTEM.model, MheIpoptConfig(horizon=2)), Ekf(SYSTEM.model)
    newest, innovations, freedoms = [], [], []
    for seed in range(100, 140):
        run = draw(SYSTEM, 6, seed)
        history = run_measurements(mhe, run.measurements, covariances=True)
        squared, freedom = nis(history)
        of_errors = nees(SYSTEM.model, history, run.states)
        newest.append(of_errors[-1])
        innovations.append(squared)
        freedoms.append(freedom)
        filtered = run_measurements(ekf, run.measurements, covariances=True)
        of_filter = nees(SYSTEM.model, filtered, run.states)
        np.testing.assert_allclose(of_errors, of_filter, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(squared, nis(filtered)[0], rtol=1e-6, atol=1e-9)
    assert consistency_of(np.array(newest), SYSTEM.model.n_x).is_inside
    assert consistency_of(np.concatenate(innovations), np.concatenate(freedoms)).is_inside


@pytest.mark.parametrize(("factor", "too_sure"), [(0.5, True), (2.0, False)])
def test_a_wrong_noise_level_is_found(factor: float, too_sure: bool) -> None:
    model = noisier(SYSTEM.model, factor)
    ekf = Ekf(model)
    newest, innovations, freedoms = [], [], []
    for seed in range(200, 230):
        run = draw(SYSTEM, 40, seed, missing=0.0)
        history = run_measurements(ekf, run.measurements, covariances=True)
        newest.append(nees(model, history, run.states)[-1])
        squared, freedom = nis(history)
        innovations.append(squared)
        freedoms.append(freedom)
    of_innovations = consistency_of(np.concatenate(innovations), np.concatenate(freedoms))
    of_errors = consistency_of(np.array(newest), model.n_x)
    for found in (of_innovations, of_errors):
        assert not found.is_inside
        assert (found.mean > found.upper) is too_sure
        assert (found.mean < found.lower) is not too_sure


def test_squared_distances_are_the_textbooks() -> None:
    """Of errors and of innovations, whatever rows are missing; NaN and 0 where all are."""
    run = draw(SYSTEM, 40, 7, missing=0.5)
    history = run_measurements(Ekf(SYSTEM.model), run.measurements, covariances=True)
    squared, freedom = nis(history)
    of_errors = nees(SYSTEM.model, history, run.states)
    assert set(freedom) == {0, 1, 2, 3}
    for k, wanted in enumerate(SYSTEM.textbook(run.measurements)):
        e, v = wanted.mean - run.states[k], wanted.innovation
        assert of_errors[k] == pytest.approx(e @ np.linalg.solve(wanted.covariance, e), rel=1e-8)
        assert freedom[k] == len(wanted.rows)
        if len(wanted.rows):
            distance = v @ np.linalg.solve(wanted.innovation_covariance, v)
            assert squared[k] == pytest.approx(distance, rel=1e-8)
        else:
            assert np.isnan(squared[k])


@pytest.mark.parametrize("rows", [(0,), (1, 2), (0, 2)])
def test_chosen_rows_alone_count(rows: tuple[int, ...]) -> None:
    """Of a sensor, whose distances a history keeps, and of two sensors, whose it does not."""
    run = draw(SYSTEM, 40, 7, missing=0.5)
    history = run_measurements(Ekf(SYSTEM.model), run.measurements, covariances=True)
    chosen = np.isin(np.arange(3), rows)
    squared, freedom = nis(history, chosen)
    for k, wanted in enumerate(SYSTEM.textbook(run.measurements)):
        kept = np.isin(wanted.rows, rows)
        assert freedom[k] == kept.sum()
        if kept.any():
            v, S = wanted.innovation[kept], wanted.innovation_covariance[np.ix_(kept, kept)]
            assert squared[k] == pytest.approx(v @ np.linalg.solve(S, v), rel=1e-8)
        else:
            assert np.isnan(squared[k])


def history_of(mean: Array, covariance: Array, names: tuple[str, ...]) -> EstimateHistory:
    n, nothing = len(mean), np.full((len(mean), 1), np.nan)
    return EstimateHistory(
        estimator="by hand",
        state_names=names,
        time_s=np.linspace(0.0, 1.0, n),
        mean=mean,
        std=np.full_like(mean, np.nan),
        innovation=nothing,
        innovation_std=nothing,
        squared_innovations=nothing,
        covariances=Covariances(covariance, nothing[:, :, None]),
        status=(Status.SOLVED,) * n,
        iterations=np.ones(n),
        step_time_s=np.zeros(n),
        kkt_residual=np.full(n, np.nan),
        reused_stages=np.zeros(n),
    )


def test_an_angle_is_off_the_short_way_round() -> None:
    model = pen_model(pen(5, {"gyro": Gyroscope(**GYROSCOPE)}))
    azimuth = model.state_names.index("azimuth_rad")
    mean, truth, gap = model.prior.mean[None, :].repeat(3, 0), np.zeros((3, 15)), 0.02
    truth[:] = model.prior.mean
    mean[:, azimuth] = [np.pi - gap / 2, -np.pi + gap / 2, 3.0]
    truth[:, azimuth] = [-np.pi + gap / 2, np.pi - gap / 2, 3.0 + gap]
    covariance = np.diag(np.full(15, 0.1**2))[None].repeat(3, 0)
    squared = nees(model, history_of(mean, covariance, model.state_names), truth)
    assert squared == pytest.approx([(gap / 0.1) ** 2] * 3, rel=1e-9)


def test_deviations_over_nine_orders_of_magnitude() -> None:
    """e = D L z with P = D L Lᵀ D has the squared length of z, whatever the units D."""
    rng = np.random.default_rng(5)
    n_x, n = SYSTEM.model.n_x, 50
    D = np.diag([1e-6, 1e3, 1.0, 1e-4])
    L = np.tril(rng.standard_normal((n_x, n_x))) + 2 * np.eye(n_x)
    z = rng.standard_normal((n, n_x))
    covariance = (D @ L @ L.T @ D)[None].repeat(n, 0)
    history = history_of(z @ (D @ L).T, covariance, SYSTEM.model.state_names)
    squared = nees(SYSTEM.model, history, np.zeros((n, n_x)))
    np.testing.assert_allclose(squared, (z**2).sum(axis=1), rtol=1e-10)


def test_a_covariance_that_is_none_is_infinitely_inconsistent() -> None:
    """As a filter's may become that diverged; the other instants keep their values."""
    covariance = np.eye(4)[None].repeat(5, 0)
    covariance[1, 0, 1] = covariance[1, 1, 0] = 1.5  # a correlation beyond 1
    covariance[2, 3, 3] = -1e-9
    covariance[3, 2, 2] = np.nan
    history = history_of(np.ones((5, 4)), covariance, SYSTEM.model.state_names)
    squared = nees(SYSTEM.model, history, np.zeros((5, 4)))
    np.testing.assert_array_equal(squared, [4.0, np.inf, np.inf, np.inf, 4.0])
    found = consistency_of(squared, 4)
    assert found.mean == np.inf
    assert not found.is_inside


def test_unknown_truth_does_not_count() -> None:
    run = draw(SYSTEM, 20, 3)
    history = run_measurements(Ekf(SYSTEM.model), run.measurements, covariances=True)
    all_known = nees(SYSTEM.model, history, run.states)
    states = run.states.copy()
    states[4, 2] = states[11] = np.nan
    squared = nees(SYSTEM.model, history, states)
    known = np.delete(np.arange(20), [4, 11])
    assert np.isnan(squared[[4, 11]]).all()
    np.testing.assert_array_equal(squared[known], all_known[known])
    found = consistency_of(squared, 4)
    assert found.count == 18
    assert found.mean == pytest.approx(all_known[known].mean(), rel=1e-14)


def test_bad_input_is_refused() -> None:
    run = draw(SYSTEM, 5, 1)
    history = run_measurements(Ekf(SYSTEM.model), run.measurements, covariances=True)
    sentence = r"true states have shape \(4, 4\), expected \(5, 4\): one per estimate"
    with pytest.raises(InputError, match=sentence):
        nees(SYSTEM.model, history, run.states[:4])
    with pytest.raises(InputError, match=r"shape \(5, 3\), expected \(5, 4\)"):
        nees(SYSTEM.model, history, run.states[:, :3])
    with pytest.raises(InputError, match="no instant to judge consistency by"):
        consistency_of(np.full(3, np.nan), 2)
