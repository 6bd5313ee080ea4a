"""Runs in the order of arrival: rows as told first, lags in samples of one sensor, refusals."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import pen_mhe as pm
from estimation.estimator import run, run_measurements
from estimation.history import EstimateHistory
from estimation.recording import Measurement, Recording
from estimation.smoother import smoothed
from models.arrays import Array
from models.errors import InputError
from models.state_space import StateSpaceModel
from tests.estimation.test_arrivals import LATE, model, recording

pytestmark = pytest.mark.usefixtures("interpreted")
LAG = 3


def late_camera(n: int = 30) -> Recording:
    """An encoder at 100 Hz, a camera at 40 Hz between its samples and 25 ms late."""
    rng = np.random.default_rng(5)
    encoder, camera = 0.01 * np.arange(n), 0.004 + 0.025 * np.arange(n // 3)
    return Recording.from_sensors(
        "late",
        {
            "encoder": (encoder, rng.standard_normal((n, 1))),
            "camera": (camera, rng.standard_normal((n // 3, 1))),
        },
        arrivals={"camera": np.round(camera + 0.025, 9)},
    )


def lagged(lags: tuple[int, ...], **options: Any) -> tuple[EstimateHistory, Array]:
    given = late_camera()
    mhe = pm.create_estimator("mhe-rti", model(), horizon=10, lag_samples=lags)
    return run(mhe, given, causal=True, **options), given.sensor("encoder")[0]


@pytest.mark.parametrize("name", ["ekf", "mhe-rti", "mhe", "mhe-ipopt"])
def test_a_row_is_told_when_something_arrives(name: str) -> None:
    estimator = pm.create_estimator(name, model())
    history = run(estimator, recording(), causal=True)
    np.testing.assert_array_equal(history.arrival_s, [0.0, 0.01, 0.02, 0.025, 0.03])
    np.testing.assert_array_equal(history.time_s, [0.0, 0.01, 0.02, 0.02, 0.03])
    first = history.at(np.array([0.03, 0.02]))
    np.testing.assert_array_equal(first.mean, history.mean[[4, 2]])
    np.testing.assert_array_equal(first.arrival_s, [0.03, 0.02])
    told = history.first_told()
    np.testing.assert_array_equal(told.time_s, [0.0, 0.01, 0.02, 0.03])
    np.testing.assert_array_equal(told.mean, np.delete(history.mean, LATE, axis=0))
    steps = run_measurements(estimator, recording().measurements(model(), causal=True))
    np.testing.assert_array_equal(steps.arrival_s, history.arrival_s)
    np.testing.assert_array_equal(steps.time_s, history.time_s)


def test_in_order_of_capture_arrival_is_capture() -> None:
    ekf = pm.create_estimator("ekf", model())
    history = run(ekf, recording())
    np.testing.assert_array_equal(history.arrival_s, history.time_s)
    assert "arrival_s" not in history.to_pandas()
    assert len(history.first_told()) == len(history)
    seen = list[Any]()
    steps = run(ekf, recording(), on_step=seen.append)
    np.testing.assert_array_equal(steps.arrival_s, history.time_s)


def test_a_live_stream_is_taken_in_its_order() -> None:
    stream = [Measurement(t, np.array([1.0, np.nan])) for t in (0.0, 0.1, 0.05)]
    history = run_measurements(pm.create_estimator("ekf", model()), stream)
    np.testing.assert_array_equal(history.arrival_s, [0.0, 0.1, 0.1])


def test_without_delays_a_causal_run_is_the_run() -> None:
    ekf = pm.create_estimator("ekf", model())
    given = dataclasses.replace(recording(), arrivals={})
    plain, causal = run(ekf, given), run(ekf, given, causal=True)
    np.testing.assert_array_equal(causal.mean, plain.mean)
    np.testing.assert_array_equal(causal.std, plain.std)


def test_the_table_says_when_a_row_was_told_where_that_differs() -> None:
    table = run(pm.create_estimator("ekf", model()), recording(), causal=True).to_pandas()
    assert list(table.columns[:2]) == ["time_s", "arrival_s"]
    assert table["arrival_s"][LATE] == 0.025


def test_a_lag_counts_the_samples_of_one_sensor() -> None:
    """A sample is spoken of by the lag of as many stages as stand behind it by then."""
    history, encoder = lagged((3, 4, 5, 6), covariances=True)
    told = history.at_lag_of(LAG, encoder)
    np.testing.assert_array_equal(told.time_s, encoder[:-LAG])
    np.testing.assert_array_equal(told.arrival_s, encoder[LAG:])
    by_then = history.at(encoder[LAG:])
    used = set()
    for row, instant in enumerate(encoder[:-LAG]):
        lag = next(k for k in (3, 4, 5, 6) if by_then.lagged[k].time_s[row] == instant)
        np.testing.assert_array_equal(told.mean[row], by_then.lagged[lag].mean[row])
        np.testing.assert_array_equal(told.std[row], by_then.lagged[lag].std[row])
        P = by_then.lagged[lag].covariance
        assert P is not None
        np.testing.assert_array_equal(told.covariance[row], P[row])
        used.add(lag)
    assert 3 in used
    assert np.isnan(told.innovation).all()
    np.testing.assert_array_equal(history.at_lag_of(0, encoder).mean, history.at(encoder).mean)


def test_a_lag_that_is_not_there_is_refused() -> None:
    history, encoder = lagged((2,))
    with pytest.raises(InputError, match=r"0 s lies more than 2 instants .* before 0\.03 s"):
        history.at_lag_of(3, encoder)
    with pytest.raises(InputError, match="a lag of -1 samples, expected 0 or more"):
        history.at_lag_of(-1, encoder)
    with pytest.raises(InputError, match=r"no estimate at 0.0123 s"):
        history.at_lag_of(1, np.array([0.0, 0.0123]))


def test_a_smoother_is_not_for_causal_runs() -> None:
    walk: StateSpaceModel = model()
    history = run(pm.create_estimator("ekf", walk), recording(), covariances=True, causal=True)
    with pytest.raises(InputError, match="late readings have made some of these, expected"):
        smoothed(walk, recording(), history)


def test_an_instant_that_is_told_again_is_drawn_and_compared_once() -> None:
    history = run(pm.create_estimator("ekf", model()), recording(), causal=True)
    [line] = history.plot().axes[0].get_lines()
    np.testing.assert_array_equal(line.get_xdata(), [0.0, 0.01, 0.02, 0.03])
    claimed = pm.compare({"a": history}).table["position_m_std"]["a"]
    assert claimed == pytest.approx(np.sqrt(np.mean(history.first_told().std ** 2)), rel=1e-12)
