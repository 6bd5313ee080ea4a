"""From a history to an outcome and its series."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.tasks.history import outcome, state_series
from benchmark.tasks.task import Quantity
from estimation.recording import Truth
from tests.benchmark.hand_made import history

TIME_S = np.arange(100) / 10
MEAN = np.column_stack([TIME_S, -2 * TIME_S])
HISTORY = history(("tip_x_m", "elevation_rad"), TIME_S, MEAN, std=0.25, failed=5)


def test_steps_are_counted_and_timed() -> None:
    quantity = Quantity.single("a", "s", 1.0)
    found = outcome("model", HISTORY, [quantity], "mirror", "so it is")
    assert (found.model, found.quantities, found.series) == ("model", (quantity,), ())
    assert (found.status, found.reason) == ("mirror", "so it is")
    assert (found.samples, found.solved_fraction) == (100, 0.95)
    # Step k takes k + 1 seconds.
    assert found.step_time_median_s == 50.5
    assert found.step_time_p99_s == pytest.approx(1 + 0.99 * 99)


def test_a_series_is_in_its_own_unit() -> None:
    truth = Truth(TIME_S, ("elevation_rad",), TIME_S[:, None] + 1)
    found = state_series(HISTORY, truth, "elevation_rad", "elevation", "half rad", 2.0)
    assert (found.quantity, found.unit) == ("elevation", "half rad")
    assert np.array_equal(found.time_s, TIME_S)
    assert np.array_equal(found.estimate, -4 * TIME_S)
    assert found.std == pytest.approx(0.5 * np.ones(100))
    assert found.truth is not None
    assert np.array_equal(found.truth, 2 * (TIME_S + 1))
    assert state_series(HISTORY, None, "tip_x_m", "x", "mm", 1e3).truth is None
