"""Late readings of a model with known inputs, and beside a detector of rest."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.recording import Measurement
from pen_mhe.estimators import create_estimator, settings_read
from recordings.simulate_pen import simulate_model
from tests.closeness import covariance_error, mean_error
from tests.estimation.resting import inertial, instants, model_at_rest
from tests.estimation.test_inputs import force, spring
from tests.mhe.late_streams import in_order

SETTINGS = {"horizon": 9, "reuse_threshold": 0.5}


@pytest.mark.cover
@pytest.mark.parametrize("name", ["mhe-rti", "mhe", "mhe-ipopt"])
@pytest.mark.parametrize("interpolated", [(), ("force_n",)])
def test_an_input_that_is_missing_is_that_of_the_instant_before(
    interpolated: tuple[str, ...], name: str
) -> None:
    model = spring(interpolated=interpolated)
    recording = simulate_model(model, duration_s=1.2, seed=0, inputs={"force_n": force})
    rows = list(recording.measurements(model))
    estimator = create_estimator(name, model, **settings_read(name, SETTINGS))
    state, arrived = estimator.init(), list[Measurement]()
    for k, row in enumerate(rows):
        state, _ = estimator.step(state, row)
        arrived.append(row)
        if k % 3 != 2:
            continue
        at = 0.6 * rows[k - 2].time_s + 0.4 * rows[k - 1].time_s
        given = np.nan if k % 2 else 0.7
        late = Measurement(at, np.array([rows[k - 2].y[0] + 0.01, given]))
        state, estimate = estimator.step(state, late)
        known = rows[k - 2].y[1] if k % 2 else 0.7
        arrived.append(Measurement(at, np.array([late.y[0], known])))
        other = estimator.init()
        for m in in_order(arrived, model.n_y):
            other, wanted = estimator.step(other, m)
        assert mean_error(model, estimate.state.mean, wanted.state) < 1e-8
        assert covariance_error(estimate.state.covariance, wanted.state.covariance) < 1e-8
    # and those of the newest instant are held on
    missing = Measurement(rows[-1].time_s + 0.05, np.array([np.nan, np.nan]))
    told = Measurement(missing.time_s, np.array([np.nan, rows[-1].y[1]]))
    one, other_one = (estimator.step(state, m)[1] for m in (missing, told))
    np.testing.assert_array_equal(one.state.mean, other_one.state.mean)


def test_the_detector_of_rest_does_not_see_it() -> None:
    """Rest is found at the samples that it is found at without the late readings."""
    model = model_at_rest()
    time_s = instants(1.5)
    y = inertial(model, time_s, 1, bias_rad_s=0.01)
    estimator = create_estimator("mhe-rti", model, horizon=4)
    plain, _ = estimator.batch(estimator.init(), time_s[:90], y[:90])
    state, names = plain, [sensor.name for sensor in model.sensors]
    start = sum(sensor.n_r for sensor in model.sensors[: names.index("still")])
    found = []
    for k in range(90, len(time_s)):
        measurement = Measurement(float(time_s[k]), y[k])
        state, one = estimator.step(state, measurement)
        plain, other = estimator.step(plain, measurement)
        found.append(np.isfinite(one.innovation[start]))
        assert found[-1] == np.isfinite(other.innovation[start])
        if k % 10 == 0:
            late = Measurement(float(time_s[k - 2] + 1e-3), y[k - 2] + 3.0)
            state, told = estimator.step(state, late)
            assert np.isnan(told.innovation[start])
    assert any(found)
    assert not all(found)
