"""A watched step that is one call of C is what Python makes of the same step, to the last bit."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

from ekf_baseline import Ekf
from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from estimation.watch import clean_rows
from estimation.watch.one_call import CleanState
from estimation.watch.watched import Watched
from mhe import Mhe, MheRti
from models.arrays import Array
from models.pen import pen_model
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate
from tests.engines import needs_compiler

pytestmark = needs_compiler
SENSORS = ("accel", "gyro", "camera")


def stream(model: StateSpaceModel) -> list[Measurement]:
    """Return rows of which some are late, repeated, spikes, from behind a hole, or brisk."""
    recording = simulate("reference", SENSORS, motion="handwriting", duration_s=4.5, seed=3)
    time_s, y = recording.stacked(model)[:2]
    y[150, :3] += 80.0
    y[200:203, 3:6] = y[199, 3:6]
    y[260] = np.nan
    y[420:, :6] *= 1.6
    keep = (time_s < 2.7) | (time_s > 2.8)
    time_s, y = time_s[keep], y[keep]
    order = np.arange(len(time_s))
    order[[100, 101]] = order[[101, 100]]
    return [Measurement(float(time_s[k]), y[k]) for k in order]


def run(watched: Watched, rows: list[Measurement]) -> tuple[list[Any], list[Estimate]]:
    state: Any = watched.init()
    states, estimates = [], []
    for row in rows:
        state, estimate = watched.step(state, row)
        states.append(state)
        estimates.append(estimate)
    return states, estimates


def whole(watched: Watched, state: Any) -> Any:
    return watched._whole(state)


def assert_same(one: Any, other: Any) -> None:
    for name in ("memory", "std", "known"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (one.time_s, one.level, one.past.count) == (other.time_s, other.level, other.past.count)
    newest = one.past.anchors[-1].number  # how far both look back may differ, what they see not
    for row, same in zip(one.past.since(newest), other.past.since(newest), strict=True):
        assert (row.time_s, row.dropped) == (same.time_s, same.dropped)
        np.testing.assert_array_equal(row.y, same.y)


@pytest.mark.parametrize(
    "kind", [Ekf, *(pytest.param(each, marks=pytest.mark.slow) for each in (MheRti, Mhe))]
)
def test_one_call_is_a_step_and_a_look(kind: type[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    model = pen_model("reference", SENSORS)
    quick = Watched(kind(model))
    monkeypatch.setattr(clean_rows, "can_be_one_call", lambda estimator: False)
    looked = Watched(kind(model))
    rows = stream(model)
    states, estimates = run(quick, rows)
    expected_states, expected = run(looked, rows)
    assert sum(isinstance(state, CleanState) for state in states) > len(rows) / 2
    assert any(Status.OUTLIER in each.status for each in estimates)
    assert any(each.flagged.any() for each in estimates)
    for one, other in zip(estimates, expected, strict=True):
        assert (one.status, one.time_s, one.iterations) == (
            other.status,
            other.time_s,
            other.iterations,
        )
        for name in ("innovation", "innovation_covariance", "derived", "derived_std", "flagged"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        np.testing.assert_array_equal(one.state.mean, other.state.mean)
        np.testing.assert_array_equal(one.state.covariance, other.state.covariance)
    for state, same in zip(states[::7], expected_states[::7], strict=True):
        assert_same(whole(quick, state), same)


def test_a_copy_of_a_state_goes_on_alike() -> None:
    """Its addresses are of its own arrays, not of those that are gone."""
    model = pen_model("reference", SENSORS)
    watched = Watched(Ekf(model))
    rows = stream(model)
    states, estimates = run(watched, rows[:90])
    state = states[80]
    assert isinstance(state, CleanState)
    for copied in (copy.deepcopy(state), pickle.loads(pickle.dumps(state))):
        assert copied.inner_at != state.inner_at
        assert copied.told_at != state.told_at
        means = list[Array]()
        for row in rows[81:90]:
            copied, estimate = watched.step(copied, row)
            means.append(estimate.state.mean)
        np.testing.assert_array_equal(means, [each.state.mean for each in estimates[81:]])
