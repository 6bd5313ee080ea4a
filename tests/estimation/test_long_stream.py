"""A stream without end: memory stays, and single steps are the batch."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.estimate import Estimate, EstimateHistory
from estimation.recording import Measurement
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.estimation import endless

STATM = Path("/proc/self/statm")
MOST_GROWTH_BYTES = 1e6
WARM_UP = 5
"""Parts until the allocator has all it wants for a batch's arrays."""
ESTIMATORS: dict[str, Callable[[StateSpaceModel], Any]] = {
    "ekf": Ekf,
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=5)),
}
ELEVATION = 4


def resident_bytes() -> int:
    gc.collect()
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def stepped(estimator: Any, state: Any, time_s: Array, y: Array) -> tuple[Any, Estimate]:
    """Step through a part and keep nothing but its end."""
    for t, row in zip(time_s.tolist(), y, strict=True):
        state, estimate = estimator.step(state, Measurement(t, row))
    return state, estimate


def assert_end(history: EstimateHistory, estimate: Estimate) -> None:
    assert history.time_s[-1] == estimate.time_s
    std = estimate.state.std
    error_P = (history.covariance[-1] - estimate.state.covariance) / np.outer(std, std)
    assert np.abs((history.mean[-1] - estimate.state.mean) / std).max() < 1e-9
    assert np.abs(error_P).max() < 1e-9


def follow(name: str, n_parts: int) -> None:
    """Step through all parts with one estimator, in batches with another."""
    model = endless.model()
    live, batch = ESTIMATORS[name](model), ESTIMATORS[name](model)
    live_state, batch_state = live.init(), batch.init()
    truth, grown, resident = endless.loop_states()[-1], [], []
    for part, (time_s, y) in enumerate(endless.parts(n_parts)):
        warm = resident_bytes()
        live_state, estimate = stepped(live, live_state, time_s, y)
        grown.append(resident_bytes() - warm)
        batch_state, history = batch.batch(batch_state, time_s, y, covariances=True)
        assert_end(history, estimate)
        assert all(status.is_solved for status in history.status)
        del history
        resident.append(resident_bytes())
        if part:
            std = estimate.state.std
            assert abs(estimate.state.mean[ELEVATION] - truth[ELEVATION]) < 4 * std[ELEVATION]
            assert std[ELEVATION] < 0.01
            assert std[:3].max() < 0.5, "the writing area holds the position"
    assert sum(grown[1:]) < MOST_GROWTH_BYTES, grown
    assert resident[-1] - resident[min(WARM_UP, n_parts - 1)] < MOST_GROWTH_BYTES, resident


needs_statm = pytest.mark.skipif(not STATM.exists(), reason="no /proc/self/statm")


@needs_statm
@pytest.mark.parametrize("name", ["ekf", pytest.param("mhe-rti", marks=pytest.mark.slow)])
def test_twenty_thousand_samples(name: str) -> None:
    follow(name, 2)


@pytest.mark.slow
@needs_statm
@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_million_samples(name: str) -> None:
    follow(name, 100)
