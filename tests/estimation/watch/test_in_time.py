"""A watch with a deadline: by a clock that only rows of the estimator move."""

from __future__ import annotations

import time
from functools import cache
from typing import Any

import numpy as np
import pytest

from ekf_baseline import Ekf
from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from estimation.watch.config import WatchConfig
from estimation.watch.flags import Flag
from estimation.watch.watched import Watched
from mhe import MheRti
from models.pen import pen_model
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate

SENSORS = ("accel", "gyro", "camera")
ROW_S, DEADLINE_S = 1e-4, 5e-3
OWN_ROWS = 6
"""Of a step itself: with and without an outlier, to the alarm and meanwhile, and a restart."""


class FakeClock:
    """Counts the rows that any estimator takes."""

    rows = 0

    def __call__(self) -> float:
        return ROW_S * FakeClock.rows


class CostlyEkf(Ekf):
    def step(self, state: Any, measurement: Measurement) -> Any:
        FakeClock.rows += 1
        return super().step(state, measurement)

    def batch(self, state: Any, time_s: Any, y: Any, **named: Any) -> Any:
        FakeClock.rows += len(time_s)
        return super().batch(state, time_s, y, **named)


@cache
def model() -> StateSpaceModel:
    return pen_model("reference", SENSORS)


@cache
def rows() -> tuple[Measurement, ...]:
    """Return four seconds; from 2 s on the camera mirrors the attitude."""
    recording = simulate("reference", SENSORS, motion="handwriting", duration_s=4.0, seed=4)
    time_s, y = recording.stacked(model())[:2]
    y[time_s > 2.0, 9:] *= -1
    return tuple(Measurement(float(t), row) for t, row in zip(time_s, y, strict=True))


@cache
def run(deadline_s: float | None) -> tuple[list[Estimate], list[float]]:
    """Return estimates, and how long each step took."""
    clock = FakeClock()
    watched = Watched(CostlyEkf(model()), WatchConfig(deadline_s=deadline_s), clock=clock)
    state: Any = watched.init()
    estimates, spent_s = list[Estimate](), list[float]()
    for row in rows():
        began_s = clock()
        state, estimate = watched.step(state, row)
        spent_s.append(clock() - began_s)
        estimates.append(estimate)
    return estimates, spent_s


def blamed(estimates: list[Estimate]) -> list[int]:
    """Return the steps at which the camera is left out."""
    camera = SENSORS.index("camera")
    return [k for k, each in enumerate(estimates) if each.flagged[camera] & Flag.LEFT_OUT]


def test_no_step_is_longer_than_its_deadline_and_itself() -> None:
    estimates, spent_s = run(None)
    in_time, kept_s = run(DEADLINE_S)
    assert max(spent_s) > 10 * DEADLINE_S, "an alarm that is worth a deadline"
    assert max(kept_s) <= DEADLINE_S + OWN_ROWS * ROW_S
    later = blamed(in_time)[0] - blamed(estimates)[0]
    assert 0 < later < 1.5 * sum(spent_s) / DEADLINE_S


def test_behind_an_alarm_all_is_as_without_a_deadline() -> None:
    estimates, _ = run(None)
    in_time, _ = run(DEADLINE_S)
    alike = [
        np.array_equal(one.state.mean, other.state.mean) and one.status == other.status
        for one, other in zip(estimates, in_time, strict=True)
    ]
    waits = [k for k, is_alike in enumerate(alike) if not is_alike]
    first, through = blamed(estimates)[0], blamed(in_time)[0]
    assert first in waits
    assert set(range(first)).isdisjoint(waits)
    assert sum(alike[through:]) > 0.5 * len(alike[through:]), "the same, to the last bit"


def test_an_alarm_that_never_ends_in_time_is_given_up() -> None:
    in_time, spent_s = run(1e-9)
    assert max(spent_s) <= OWN_ROWS * ROW_S
    assert any(Status.INCONSISTENT in each.status for each in in_time)


@pytest.mark.slow
def test_a_window_by_the_time_of_the_processor() -> None:
    config = WatchConfig(deadline_s=3 * DEADLINE_S)
    watched = Watched(MheRti(model()), config, clock=time.process_time)
    history = watched.batch(
        watched.init(), np.array([row.time_s for row in rows()]), np.array([r.y for r in rows()])
    )[1]
    assert (history.flagged[:, SENSORS.index("camera")] & Flag.LEFT_OUT).any()
