"""What watching costs where nothing is wrong: CPU time, interleaved, the least of several runs."""

from __future__ import annotations

import time
from typing import Any

import pytest

import pen_mhe as pm
from models.arrays import Array
from tests.engines import needs_compiler

SENSORS = ("accel", "gyro", "camera")
ROUNDS = 7


def cpu_s(estimator: Any, time_s: Array, y: Array) -> float:
    state, began = estimator.init(), time.process_time()
    estimator.batch(state, time_s, y)
    return time.process_time() - began


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("name", ["mhe-rti", "mhe"])
def test_a_clean_stream_costs_a_tenth_more_at_most(name: str) -> None:
    """With kept factors, where a step is shortest."""
    recording = pm.simulate("reference", SENSORS, motion="handwriting", duration_s=60.0, seed=1)
    model = pm.pen_model("reference", SENSORS)
    bare = pm.create_estimator(name, model)
    watched = pm.watched(pm.create_estimator(name, model))
    time_s, y, *_ = (recording if name == "mhe-rti" else recording.first(20.0)).stacked(model)
    pairs = [(cpu_s(bare, time_s, y), cpu_s(watched, time_s, y)) for _ in range(ROUNDS)]
    least = [min(times) for times in zip(*pairs, strict=True)]
    assert least[1] < 1.1 * least[0]
