"""What a compiled loop would read beyond its arrays is refused in one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.recording import Measurement
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from mhe.trajectory import Trajectory
from models.errors import InputError
from tests.configs import config_for
from tests.engines import compiled_and_interpreted, needs_compiler
from tests.linear_models import coupled_system

pytestmark = needs_compiler

MODEL = coupled_system(3).model
BUILDS: dict[str, Any] = {
    "ekf": lambda: Ekf(MODEL),
    "mhe-rti": lambda: MheRti(MODEL, MheRtiConfig(horizon=3)),
    "mhe": lambda: Mhe(MODEL, MheConfig(horizon=3)),
}
WRONG_Y = [(1,), (2,), (4,), (3, 1), (1, 3), ()]
WRONG_BATCH = [((5,), (4, 3)), ((4,), (5, 3)), ((4,), (4, 1)), ((4,), (4,)), ((4, 1), (4, 3))]


@pytest.mark.cover
@pytest.mark.parametrize("name", BUILDS)
@pytest.mark.parametrize("shape", WRONG_Y)
def test_a_reading_of_another_shape(name: str, shape: tuple[int, ...]) -> None:
    for estimator in compiled_and_interpreted(BUILDS[name]):
        with pytest.raises(InputError, match=r"readings have shape \(.*\), expected \(3,\)$"):
            estimator.step(estimator.init(), Measurement(0.0, np.zeros(shape)))


@pytest.mark.parametrize("name", BUILDS)
@pytest.mark.parametrize(("times", "y"), WRONG_BATCH)
def test_a_batch_of_another_shape(name: str, times: tuple[int, ...], y: tuple[int, ...]) -> None:
    for estimator in compiled_and_interpreted(BUILDS[name]):
        with pytest.raises(InputError, match=r"(readings|times) have shape \(.*\), expected \("):
            estimator.batch(estimator.init(), np.zeros(times), np.zeros(y))


@pytest.mark.parametrize("name", BUILDS)
@pytest.mark.parametrize("time_s", [np.nan, np.inf, -np.inf])
def test_a_time_that_is_no_number(name: str, time_s: float) -> None:
    """It would make the state NaN for good."""
    for estimator in compiled_and_interpreted(BUILDS[name]):
        state, _ = estimator.step(estimator.init(), Measurement(0.0, np.zeros(3)))
        with pytest.raises(InputError, match=f"time of a measurement is {time_s}, expected a num"):
            estimator.step(state, Measurement(time_s, np.zeros(3)))
        with pytest.raises(InputError, match=f"time of a measurement is {time_s}, expected a num"):
            estimator.batch(state, np.array([1.0, time_s]), np.zeros((2, 3)))


@pytest.mark.parametrize("kind", [MheRti, Mhe])
@pytest.mark.parametrize("horizon", [2, 4])
def test_a_state_of_another_horizon(kind: type[Mhe] | type[MheRti], horizon: int) -> None:
    other = kind(MODEL, config_for(kind, horizon=horizon))
    state = other.init()
    for k in range(6):
        state, _ = other.step(state, Measurement(float(k), np.zeros(3)))
    for mhe in compiled_and_interpreted(lambda: kind(MODEL, config_for(kind, horizon=3))):
        with pytest.raises(InputError, match="estimator of another model or horizon"):
            mhe.step(state, Measurement(7.0, np.zeros(3)))
        with pytest.raises(InputError, match="estimator of another model or horizon"):
            mhe.batch(state, np.array([7.0]), np.zeros((1, 3)))


@pytest.mark.parametrize("n", [0, 5])
def test_a_window_of_another_length(n: int) -> None:
    measurements = tuple(Measurement(float(k), np.zeros(3)) for k in range(n))
    guess = Trajectory(np.zeros((n, 4)), np.zeros((max(n - 1, 0), 4)))
    for mhe in compiled_and_interpreted(lambda: Mhe(MODEL, MheConfig(horizon=3))):
        with pytest.raises(InputError, match=f"window of {n} measurements, expected 1 to 4"):
            mhe.solve(MODEL.prior, measurements, guess)


def test_settings_may_be_of_any_number_type() -> None:
    """They become C numbers: a whole number where C has a double must not fail to compile."""
    settings: dict[str, Any] = {"tolerance": 1, "sparse_noise": 2, "deadline_s": 10}
    numbers: dict[str, Any] = {"horizon": np.int64(3), "max_iterations": np.int32(50)}
    whole = MheConfig(huber={"first": 2}, **numbers, **settings)
    plain = MheConfig(
        horizon=3,
        tolerance=1.0,
        sparse_noise=2.0,
        deadline_s=10.0,
        huber={"first": 2.0},
        max_iterations=50,
    )
    time_s, y = np.arange(8.0), np.random.default_rng(1).standard_normal((8, 3))
    histories = []
    for config in (whole, plain):
        mhe = Mhe(MODEL, config)
        histories.append(mhe.batch(mhe.init(), time_s, y)[1])
    np.testing.assert_array_equal(histories[0].mean, histories[1].mean)
