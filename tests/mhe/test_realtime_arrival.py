"""The real-time window's prior: the dropped stage eliminated, by hand, on a curved model."""

from __future__ import annotations

import numpy as np
import pytest

from mhe.arrival_cost import RELINEARISATION_LIMIT
from tests.closeness import covariance_error, mean_error
from tests.configs import config_for
from tests.mhe import pendulum
from tests.mhe.runs import REAL_TIME
from tests.mhe.windows import moves, real_time

TOLERANCE_STD = 1e-10


@pytest.mark.parametrize("estimator", REAL_TIME)
@pytest.mark.parametrize("arrival_cost", ["filtered", "smoothed"])
def test_the_dropped_stage_is_eliminated(arrival_cost: str, estimator: str) -> None:
    """Smoothed: at the window's trajectory. Filtered: there only where the mean misjudges."""
    measurements, at_window = pendulum.simulate(60, seed=2), []
    config = config_for(estimator, horizon=4, arrival_cost=arrival_cost, reuse_threshold=0.0)
    mhe = real_time(estimator, pendulum.model(), config)
    for k, move in enumerate(moves(mhe, measurements)):
        if k < 5:
            np.testing.assert_array_equal(move.prior.mean, pendulum.PRIOR_MEAN)
            continue
        before, dropped = move.before, measurements[k - 5]
        x, w, mean = before.x[0], before.w[0], before.prior.mean
        # Only sinθ is curved: what a tangent at the mean gets wrong of it.
        curved = np.sin(x[0]) - np.sin(mean[0]) - np.cos(mean[0]) * (x[0] - mean[0])
        far = abs(curved) / pendulum.SINE_STD > RELINEARISATION_LIMIT
        far = arrival_cost == "smoothed" or (far and not np.isnan(dropped.y[0]))
        dt = measurements[k - 4].time_s - dropped.time_s
        wanted = pendulum.eliminate(before.prior, dropped, dt, *((x, w) if far else (mean, None)))
        assert mean_error(mhe.model, move.prior.mean, wanted) < TOLERANCE_STD
        assert covariance_error(move.prior.covariance, wanted.covariance) < TOLERANCE_STD
        at_window.append(far)
    assert len(at_window) == 55
    assert any(at_window)
    assert all(at_window) == (arrival_cost == "smoothed")


@pytest.mark.parametrize("estimator", REAL_TIME)
def test_constant_stands_on_the_prediction_of_its_stage(estimator: str) -> None:
    measurements = pendulum.simulate(20, seed=3)
    mhe = real_time(
        estimator, pendulum.model(), config_for(estimator, horizon=4, arrival_cost="constant")
    )
    predicted = []
    for move in moves(mhe, measurements):
        predicted.append(move.guess.states[-1])
        np.testing.assert_array_equal(move.prior.covariance, np.diag(pendulum.PRIOR_STD**2))
        first = max(0, len(predicted) - 5)
        np.testing.assert_allclose(move.prior.mean, predicted[first], rtol=0, atol=1e-13)
