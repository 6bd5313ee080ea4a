"""An EKF whose every update, the first too, is linearised at its prior: the stage, step by step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


def plain_filter(
    model: StateSpaceModel, measurements: Sequence[Measurement]
) -> Iterator[GaussianState]:
    """Yield x_k|k after each measurement."""
    stage, state, before = KalmanStage(model), model.prior, None
    for measurement in measurements:
        if before is not None:
            state = stage.predict(state, measurement.time_s - before).state
        state = stage.update(state, measurement.y).state
        before = measurement.time_s
        yield state
