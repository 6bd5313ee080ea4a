"""The real-time window's prior: the dropped stage eliminated, by hand, on a curved model."""

from __future__ import annotations

import numpy as np
import pytest

from tests.closeness import covariance_error, mean_error
from tests.configs import config_for
from tests.mhe import pendulum
from tests.mhe.runs import REAL_TIME
from tests.mhe.windows import moves, real_time

TOLERANCE_STD = 1e-10


@pytest.mark.parametrize("estimator", REAL_TIME)
@pytest.mark.parametrize("arrival_cost", ["filtered", "smoothed"])
def test_the_dropped_stage_is_eliminated(arrival_cost: str, estimator: str) -> None:
    """Smoothed: at the window's trajectory. Filtered: at the filter's own mean."""
    measurements, apart = pendulum.simulate(60, seed=2), []
    config = config_for(estimator, horizon=4, arrival_cost=arrival_cost, reuse_threshold=0.0)
    mhe = real_time(estimator, pendulum.model(), config)
    for k, move in enumerate(moves(mhe, measurements)):
        if k < 5:
            np.testing.assert_array_equal(move.prior.mean, pendulum.PRIOR_MEAN)
            continue
        before, dropped = move.before, measurements[k - 5]
        x, w, mean = before.x[0], before.w[0], before.prior.mean
        dt = measurements[k - 4].time_s - dropped.time_s
        at = {"smoothed": (x, w), "filtered": (mean, None)}
        wanted = pendulum.eliminate(before.prior, dropped, dt, *at[arrival_cost])
        assert mean_error(mhe.model, move.prior.mean, wanted) < TOLERANCE_STD
        assert covariance_error(move.prior.covariance, wanted.covariance) < TOLERANCE_STD
        apart.append(float(np.abs((x - mean) / before.prior.std).max()))
    assert len(apart) == 55
    assert max(apart) > 1  # both are not one and the same


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
