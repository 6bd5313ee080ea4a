"""Models with one state, one sensor row or no sensor: the shapes hold."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.kalman_stage import KalmanStage
from tests.linear_models import coupled_system, random_walk_system


@pytest.mark.parametrize("copies", [1, 2])
def test_shapes_of_a_stage(copies: int) -> None:
    model = random_walk_system(copies, q=1.0, r=1.0, p0=1.0).model
    stage = KalmanStage(model)
    predicted = stage.predict(model.prior, 1.0).state
    update = stage.update(predicted, np.full(copies, 0.5))
    assert predicted.mean.shape == update.state.mean.shape == (copies,)
    assert predicted.covariance.shape == (copies, copies)
    assert update.state.covariance.shape == (copies, copies)
    assert update.state.std.shape == (copies,)
    assert update.W.shape == update.H.shape == (copies, copies)


def test_a_model_without_sensors_predicts() -> None:
    system = coupled_system(1)
    model = system.model.replace(sensors=())
    stage = KalmanStage(model)
    update = stage.update(stage.predict(model.prior, 0.1).state, np.zeros(0))
    wanted = system.F(0.1) @ model.prior.mean
    np.testing.assert_allclose(update.state.mean, wanted, rtol=0, atol=1e-13)
    assert update.innovation.shape == (0,)
    assert update.innovation_covariance.shape == (0, 0)
