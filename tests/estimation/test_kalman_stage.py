"""The Kalman stage against textbook formulas, at its own mean and elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.kalman_stage import KalmanStage, rows_present
from models.arrays import Array
from models.gaussian import GaussianState
from models.pen import pen_model
from tests.estimation.pens import draw_pen_run, pen_config
from tests.linear_models import coupled_system
from tests.references import kalman

SYSTEM = coupled_system(7)
RUN = draw_pen_run(40, 4)


@pytest.fixture(scope="module")
def pen_stage() -> KalmanStage:
    return KalmanStage(RUN.model)


def relative(P: Array, wanted: Array) -> float:
    """Largest deviation in units of the standard deviations' outer product."""
    std = np.sqrt(np.diag(wanted))
    return float(np.abs((P - wanted) / np.outer(std, std)).max())


def moving_states(stage: KalmanStage) -> list[tuple[GaussianState, Array, float]]:
    """Predicted states along a run of the pen, with the readings and steps that follow."""
    gaussian, collected = stage.model.prior, []
    times = [m.time_s for m in RUN.measurements]
    for k, measurement in enumerate(RUN.measurements):
        if k:
            gaussian = stage.predict(gaussian, times[k] - times[k - 1]).state
        collected.append((gaussian, measurement.y, times[k]))
        gaussian = stage.update(gaussian, measurement.y).state
    return collected


def test_covariance_agrees_with_josephs_form_on_the_pen(pen_stage: KalmanStage) -> None:
    R = np.diag(RUN.model.noise_std**2)
    updated_with_camera = 0
    for predicted, y, _ in moving_states(pen_stage):
        update = pen_stage.update(predicted, y)
        rows = update.present
        H, S = update.H[rows], update.innovation_covariance[np.ix_(rows, rows)]
        K = np.linalg.solve(S, H @ predicted.covariance).T
        wanted = kalman.joseph(predicted.covariance, K, H, R[np.ix_(rows, rows)])
        assert relative(update.state.covariance, wanted) < 1e-10
        np.testing.assert_array_equal(update.state.covariance, update.state.covariance.T)
        updated_with_camera += int(rows[6:].any())
    assert updated_with_camera > 10


def test_factors_are_what_they_say(pen_stage: KalmanStage) -> None:
    for predicted, y, _ in moving_states(pen_stage)[:6]:
        update = pen_stage.update(predicted, y)
        P, H, S = predicted.covariance, update.H, update.innovation_covariance
        R = np.diag(RUN.model.noise_std**2)
        np.testing.assert_allclose(S, H @ P @ H.T + R, rtol=1e-11, atol=1e-14)
        L = np.linalg.cholesky(S)
        np.testing.assert_allclose(update.W @ L.T, P @ H.T, rtol=0, atol=1e-11)
        np.testing.assert_allclose(L @ update.e, update.innovation, rtol=0, atol=1e-11)
        assert (H[~update.present] == 0).all()
        assert (update.innovation[~update.present] == 0).all()


def test_derivative_of_the_readings_is_theirs(pen_stage: KalmanStage) -> None:
    """H by central differences of the sensors' residuals along the tangent space."""
    model, step = RUN.model, 1e-6
    predicted, y, _ = moving_states(pen_stage)[1]  # the camera's first frame
    update = pen_stage.update(predicted, y)
    sensors = zip(model.sensors, (y[:3], y[3:6], y[6:]), strict=True)
    blocks = []
    for sensor, reading in sensors:
        reading = np.nan_to_num(reading)
        columns = []
        for e in np.eye(model.n_x):
            ahead, behind = (predicted.mean + sign * step * e for sign in (1, -1))
            residual = [np.asarray(sensor.residual(reading, x)).ravel() for x in (ahead, behind)]
            columns.append(-(residual[0] - residual[1]) / (2 * step))
        blocks.append(np.array(columns).T)
    wanted = np.vstack(blocks) * update.present[:, None]
    assert update.present[6:].all()
    np.testing.assert_allclose(update.H, wanted, rtol=0, atol=1e-7 * np.abs(wanted).max())


def test_update_without_rows_changes_nothing(pen_stage: KalmanStage) -> None:
    predicted, y, _ = moving_states(pen_stage)[9]
    update = pen_stage.update(predicted, np.full_like(y, np.nan))
    np.testing.assert_array_equal(update.state.mean, predicted.mean)
    lower = np.tril(predicted.covariance)  # the upper triangle is another sum of the same products
    np.testing.assert_array_equal(np.tril(update.state.covariance), lower)
    np.testing.assert_array_equal(update.state.covariance, update.state.covariance.T)
    assert not update.present.any()


def test_a_row_is_missing_when_any_reading_it_needs_is() -> None:
    model = RUN.model
    y = np.arange(12.0)
    assert rows_present(model, y).all()
    y[1] = y[10] = np.nan  # accel y; one component of the camera's rotation vector
    wanted = [True, False, True] + [True] * 3 + [True] * 3 + [False] * 2
    np.testing.assert_array_equal(rows_present(model, y), wanted)


def test_linear_stage_is_the_same_at_every_linearisation_point() -> None:
    stage, rng = KalmanStage(SYSTEM.model), np.random.default_rng(2)
    y, dt = np.array([0.3, np.nan, -0.4]), 0.07
    wanted = kalman.update(
        *kalman.predict(
            SYSTEM.model.prior.mean, SYSTEM.model.prior.covariance, SYSTEM.F(dt), SYSTEM.Q(dt)
        ),
        y,
        SYSTEM.H,
        SYSTEM.R,
    )
    std = np.sqrt(np.diag(wanted.covariance))
    for _ in range(5):
        x, w = 3 * rng.standard_normal(4), rng.standard_normal(4)
        predicted = stage.predict(SYSTEM.model.prior, dt, x_lin=x, w_lin=w).state
        update = stage.update(predicted, y, x_lin=3 * rng.standard_normal(4))
        assert np.abs((update.state.mean - wanted.mean) / std).max() < 1e-11
        assert relative(update.state.covariance, wanted.covariance) < 1e-11


def test_splitting_a_step_changes_nothing(pen_stage: KalmanStage) -> None:
    for predicted, y, _ in moving_states(pen_stage)[3::5]:
        updated = pen_stage.update(predicted, y).state
        whole = pen_stage.predict(updated, 0.013).state
        split = updated
        for dt in (0.002, 0.0, 0.0105, 0.0005):
            split = pen_stage.predict(split, dt).state
        std = whole.std
        assert np.abs((split.mean - whole.mean) / std).max() < 1e-10
        assert relative(split.covariance, whole.covariance) < 1e-10


def test_angles_cross_half_a_turn(pen_stage: KalmanStage) -> None:
    """A camera that sees azimuth just past π pulls the short way round."""
    mean = RUN.model.prior.mean.copy()
    mean[3] = np.pi - 0.02
    prior = GaussianState(mean, RUN.model.prior.covariance)
    beyond = mean.copy()
    beyond[3] = -np.pi + 0.03
    readings = [np.full(3, np.nan), np.full(3, np.nan), RUN.model.sensor("camera").h(beyond)]
    y = np.concatenate([np.asarray(reading).ravel() for reading in readings])
    azimuth = pen_stage.update(prior, y).state.mean[3]
    assert -np.pi <= azimuth <= -np.pi + 0.031


def test_covariance_stays_positive_definite_on_a_long_stream() -> None:
    """Without a position sensor variances grow without bound while others stay small."""
    model = pen_model(pen_config(), ["accel", "gyro"], writing_area=False)
    stage, gaussian, y = KalmanStage(model), model.prior, np.zeros(6)
    smallest = np.inf
    for _ in range(3000):
        gaussian = stage.predict(
            stage.update(gaussian, y, x_lin=model.prior.mean).state, 0.01
        ).state
        correlation = gaussian.covariance / np.outer(gaussian.std, gaussian.std)
        smallest = min(smallest, float(np.linalg.eigvalsh(correlation)[0]))
    assert gaussian.std[:3].max() > 100.0  # m
    assert smallest > 1e-6  # 2e-5 in 80-bit arithmetic
