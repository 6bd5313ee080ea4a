"""Times per sample, frames in time and late: what counts with which sample, and a row for each."""

from __future__ import annotations

import numpy as np
import pytest

from suites.real_time import late_times
from suites.real_time.late_times import CONTENDERS, ORDERS, late_rows, per_sample
from suites.real_time.streams import simulated


def test_a_frame_counts_with_the_sample_behind_it() -> None:
    took = np.array([1.0, 20.0, 2.0, 3.0, 40.0])
    is_sample = np.array([True, False, True, True, False])
    np.testing.assert_array_equal(per_sample(took, is_sample), [1.0, 22.0, 3.0])


def test_every_contender_has_a_row_for_both_orders(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(late_times, "ROUNDS", 1)
    stream = simulated("pen24", seconds=0.5)
    rows = late_rows(stream)
    assert [(row.contender, row.frames) for row in rows] == [
        (name, order) for name in CONTENDERS for order in ORDERS
    ]
    samples = len(stream.recording.sensor("accel")[0])
    for row in rows:
        assert row.samples == samples
        assert 0 < row.median_s <= row.p99_s
        assert row.with_frame_s > 0
