"""What watching costs where nothing is wrong: CPU time, interleaved, the least of several runs."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest

import pen_mhe as pm
from estimation.recording import Measurement
from models.arrays import Array
from tests.engines import needs_compiler

SENSORS = ("accel", "gyro", "camera")
ROUNDS, START = 7, 30
LONG_S = {"ekf": 300.0, "mhe-rti": 60.0, "mhe": 20.0}
"""Streams so long that what a start costs is no part of a step."""


def batch_s(estimator: Any, time_s: Array, y: Array) -> float:
    state, began = estimator.init(), time.process_time()
    estimator.batch(state, time_s, y)
    return time.process_time() - began


def live_s(estimator: Any, time_s: Array, y: Array) -> float:
    """Behind the start, at which nothing is judged."""
    state, rows = estimator.init(), list(map(Measurement, time_s.tolist(), y))
    for row in rows[:START]:
        state, _ = estimator.step(state, row)
    began = time.process_time()
    for row in rows[START:]:
        state, _ = estimator.step(state, row)
    return time.process_time() - began


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("cpu_s", [batch_s, live_s])
@pytest.mark.parametrize("name", LONG_S)
def test_a_clean_stream_costs_little_more(
    name: str, cpu_s: Callable[[Any, Array, Array], float]
) -> None:
    """A tenth, with kept factors too, where a window's step is shortest."""
    recording = pm.simulate(
        "reference", SENSORS, motion="handwriting", duration_s=LONG_S[name], seed=1
    )
    model = pm.pen_model("reference", SENSORS)
    bare = pm.create_estimator(name, model)
    watched = pm.watched(pm.create_estimator(name, model))
    time_s, y, *_ = recording.stacked(model)
    pairs = [(cpu_s(bare, time_s, y), cpu_s(watched, time_s, y)) for _ in range(ROUNDS)]
    least = [min(times) for times in zip(*pairs, strict=True)]
    assert least[1] < 1.1 * least[0]
