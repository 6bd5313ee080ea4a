"""Times per sample, frames in time and late: what counts with which sample."""

from __future__ import annotations

import numpy as np
import pytest

from suites.real_time import late_times
from suites.real_time.late_times import CONTENDERS, ORDERS, late_race, ordered, per_sample
from suites.real_time.sample_times import FRAME, MEAN, MEDIAN, P99, time_quantities
from suites.real_time.streams import simulated


def test_a_frame_counts_with_the_sample_behind_it() -> None:
    took = np.array([1.0, 20.0, 2.0, 3.0, 40.0])
    is_sample = np.array([True, False, True, True, False])
    np.testing.assert_array_equal(per_sample(took, is_sample), [1.0, 22.0, 3.0])


def test_times_are_told_of_all_and_of_those_with_a_frame() -> None:
    times = np.array([1.0, 2.0, 6.0]) * 1e-6
    found = time_quantities(times, np.array([False, True, True]), ", here")
    assert {quantity.name: quantity.bias for quantity in found} == pytest.approx(
        {
            "median time, here": 2.0,
            "mean time, here": 3.0,
            "99 % time, here": float(np.quantile([1.0, 2.0, 6.0], 0.99)),
            "longest time, here": 6.0,
            "median time with a frame, here": 4.0,
        }
    )


def test_every_contender_has_times_in_both_orders(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(late_times, "ROUNDS", 1)
    stream = simulated("pen24", seconds=0.5)
    found = late_race(stream)
    assert list(found) == list(CONTENDERS)
    samples = len(stream.recording.sensor("accel")[0])
    for outcome in found.values():
        assert outcome.samples == samples
        figures = {quantity.name: quantity.bias for quantity in outcome.quantities}
        for order in ORDERS:
            median, mean, p99, frame = (
                figures[name + ordered(order)] for name in (MEDIAN, MEAN, P99, FRAME)
            )
            assert 0 < median <= p99
            assert mean > 0
            assert frame > 0
