"""What arrives later changes no earlier estimate by one bit, and a batch is its steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.estimate import EstimateHistory
from estimation.estimator import run_measurements
from estimation.recording import Measurement
from tests.configs import config_for
from tests.engines import needs_compiler
from tests.estimation import pens
from tests.mhe.late_streams import is_late, late_stream
from tests.mhe.windows import real_time

pytestmark = needs_compiler

RUN = pens.draw_pen_run(44, seed=8)
STREAM = late_stream(RUN.model, RUN.measurements, np.random.default_rng(3))
ESTIMATORS: dict[str, tuple[str, dict[str, Any]]] = {
    "kept": ("mhe-rti", {"reuse_threshold": 0.5}),
    "full": ("mhe-rti", {"reuse_threshold": 0.0}),
    "losses": ("mhe-rti", {"huber": {"accel": 1.5}, "sparse_noise": 2.0}),
    "converged": ("mhe", {}),
}


def batch(name: str, stream: list[Measurement]) -> EstimateHistory:
    estimator, settings = ESTIMATORS[name]
    config = config_for(estimator, horizon=16, lag_samples=14, **settings)
    mhe = real_time(estimator, RUN.model, config)
    times, y = np.array([m.time_s for m in stream]), np.array([m.y for m in stream])
    return mhe.batch(mhe.init(), times, y, covariances=True)[1]


def assert_same(one: EstimateHistory, other: EstimateHistory) -> None:
    for name in ("time_s", "mean", "covariance", "innovation", "innovation_covariance"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    assert one.status == other.status
    for name in ("time_s", "mean", "std"):
        pair = (getattr(history.lagged[14], name) for history in (one, other))
        np.testing.assert_array_equal(*pair, err_msg=name)


def changed(rng: np.random.Generator) -> list[Measurement]:
    """Other readings, some missing, others twice, in another order."""
    rows = [
        Measurement(m.time_s, np.where(rng.uniform(size=len(m.y)) < 0.2, np.nan, m.y + 0.3))
        for m in rng.permutation(np.array(STREAM, dtype=object))
    ]
    return rows[: len(rows) * 2 // 3]


@pytest.mark.parametrize("name", ESTIMATORS)
def test_the_future_changes_nothing(name: str) -> None:
    rng, whole = np.random.default_rng(6), batch(name, STREAM)
    late = [k for k in range(len(STREAM)) if is_late(STREAM, k)]
    assert len(late) > 8
    for k in (late[2], late[-2], late[-2] + 1):
        assert_same(batch(name, [*STREAM[:k], *changed(rng)])[:k], whole[:k])


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_batch_is_its_steps(name: str) -> None:
    estimator, settings = ESTIMATORS[name]
    config = config_for(estimator, horizon=16, lag_samples=14, **settings)
    mhe = real_time(estimator, RUN.model, config)
    assert_same(run_measurements(mhe, STREAM, covariances=True), batch(name, STREAM))
