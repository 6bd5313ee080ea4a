"""Bounded influence: a reading far off moves a state by k of its deviations, no further."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from ekf_baseline.ekf import Ekf, EkfConfig, EkfState
from ekf_baseline.outliers import needed
from estimation.recording import Measurement
from models.arrays import Array
from models.errors import InputError
from tests.closeness import estimate_error
from tests.disturbed import disturbed
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens
from tests.linear_models import coupled_system
from tests.references import kalman

SYSTEM = coupled_system(5)
SECOND = [1, 2]
"""Rows of the system's second sensor."""
K = 2.5


def settled(config: EkfConfig | None = None) -> tuple[Ekf, EkfState]:
    """An EKF some steps into a run without outliers, with its state."""
    plain, ekf = Ekf(SYSTEM.model), Ekf(SYSTEM.model, config)
    state, rng = plain.init(), np.random.default_rng(3)
    for measurement in SYSTEM.simulate(np.arange(1, 20) * 0.05, rng, missing=0.0):
        state, _ = plain.step(state, measurement)
    return ekf, state


def prediction(state: EkfState) -> tuple[Array, Array]:
    mean, covariance = state.gaussian.mean, state.gaussian.covariance
    return kalman.predict(mean, covariance, SYSTEM.F(0.05), SYSTEM.Q(0.05))


def weight_by_root(v: Array, HPH: Array, R: Array) -> float:
    """ω by bisection on its definition: d² of S with R / ω is K²."""

    def beyond(log_omega: float) -> float:
        S = HPH + R / np.exp(log_omega)
        return float(v @ np.linalg.solve(S, v)) - K**2

    return float(np.exp(brentq(beyond, -60, 0, xtol=1e-14)))


@pytest.mark.parametrize("off", [3.0, 40.0, 1e4])
def test_it_is_the_kalman_filter_with_the_noise_that_brings_the_distance_to_k(off: float) -> None:
    ekf, state = settled(EkfConfig(huber={"second": K}))
    x, P = prediction(state)
    y = SYSTEM.H @ x + np.array([0.05, off, 0.1])
    _, estimate = ekf.step(state, Measurement(1.0, y))
    H, R = SYSTEM.H[SECOND], SYSTEM.R[np.ix_(SECOND, SECOND)]
    omega = weight_by_root(y[SECOND] - H @ x, H @ P @ H.T, R)
    assert omega < 1
    noise = SYSTEM.R.copy()
    noise[np.ix_(SECOND, SECOND)] = R / omega
    wanted = kalman.update(x, P, y, SYSTEM.H, noise)
    std = np.sqrt(np.diag(wanted.covariance))
    assert np.abs((estimate.state.mean - wanted.mean) / std).max() < 1e-6
    assert np.abs((estimate.state.covariance - wanted.covariance) / np.outer(std, std)).max() < 1e-7
    np.testing.assert_allclose(estimate.innovation, y - SYSTEM.H @ x, rtol=0, atol=1e-9)


def test_the_shift_has_a_bound_whatever_the_reading() -> None:
    ekf, state = settled(EkfConfig(huber={"second": K}))
    x, P = prediction(state)
    for off in (1e2, 1e6):
        y = np.array([np.nan, *(SYSTEM.H @ x + off)[SECOND]])
        _, estimate = ekf.step(state, Measurement(1.0, y))
        shift = estimate.state.mean - x
        assert shift @ np.linalg.solve(P, shift) < K**2 * (1 + 1e-6)


def test_a_reading_within_the_threshold_is_least_squares_to_the_bit() -> None:
    ekf, state = settled(EkfConfig(huber={"second": 50.0}))
    plain, _ = settled()
    measurement = Measurement(1.0, SYSTEM.H @ prediction(state)[0] + 0.1)
    (_, a), (_, b) = ekf.step(state, measurement), plain.step(state, measurement)
    np.testing.assert_array_equal(a.state.mean, b.state.mean)
    np.testing.assert_array_equal(a.state.covariance, b.state.covariance)


def test_first_readings_of_a_sensor_count_in_full() -> None:
    """Until then only the prior speaks against them."""
    far = Measurement(0.0, SYSTEM.H @ SYSTEM.model.prior.mean + 300.0)
    for settings in ({"huber": {"first": 1.0, "second": 1.0}}, {"gate_probability": 0.99}):
        estimates = []
        for config in (EkfConfig(**settings), EkfConfig()):  # type: ignore[arg-type]
            ekf = Ekf(SYSTEM.model, config)
            estimates.append(ekf.step(ekf.init(), far)[1])
        np.testing.assert_array_equal(estimates[0].state.mean, estimates[1].state.mean)
        assert estimates[0].status is estimates[1].status


def test_a_weight_by_newton_is_that_by_bisection() -> None:
    rng = np.random.default_rng(0)
    for n in (1, 2, 6):
        for scale in (1e-4, 1.0, 1e4):
            A = rng.standard_normal((n, n))
            HPH, R = scale * A @ A.T, rng.uniform(0.5, 2.0, n)
            v = 20 * np.linalg.cholesky(HPH + np.diag(R)) @ rng.standard_normal(n)
            if v @ np.linalg.solve(HPH + np.diag(R), v) <= K**2:
                continue
            found = 1 / (1 + needed(v, HPH + np.diag(R), np.diag(R), K**2))
            assert found == pytest.approx(weight_by_root(v, HPH, np.diag(R)), rel=1e-6)


RUN = pens.draw_pen_run(60, seed=11)


@needs_compiler
@pytest.mark.parametrize(
    "settings",
    [{"huber": {"camera": 1.5}}, {"huber": {"camera": 2.0, "accel": 2.0}, "gate_probability": 0.9}],
    ids=["a loss", "losses and gates"],
)
def test_both_engines_say_the_same(settings: dict[str, object]) -> None:
    model, config = RUN.model, EkfConfig(**settings)  # type: ignore[arg-type]
    measurements = disturbed(RUN.measurements, limit=39.99, outlier=3.0)
    machine, plain = compiled_and_interpreted(lambda: Ekf(model, config))
    for a, b in zip(steps(machine, measurements), steps(plain, measurements), strict=True):
        assert estimate_error(model, a, b) < 1e-11
        assert a.status is b.status


def test_what_is_no_loss_or_gate_is_refused() -> None:
    for settings, sentence in (
        ({"huber": {"second": 0.0}}, "threshold 0.0 of Huber's loss on second, expected"),
        ({"huber": 3.0}, "huber is 3.0, expected sensor"),
        ({"gate_probability": {"second": 2.0}}, "gate_probability of second is 2.0, expected"),
    ):
        with pytest.raises(InputError, match=sentence):
            EkfConfig(**settings)  # type: ignore[arg-type]
    for config, sentence in (
        (EkfConfig(huber={"third": 1.0}), "Huber's loss on sensor third, which is not part"),
        (EkfConfig(gate_probability={"third": 0.9}), "a gate on sensor third, which is not part"),
    ):
        with pytest.raises(InputError, match=sentence):
            Ekf(SYSTEM.model, config)
