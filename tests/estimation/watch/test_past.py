"""What was known in front of a row is what the watch knew there, whoever was left out by then."""

from __future__ import annotations

import numpy as np
import pytest

from ekf_baseline import Ekf
from estimation.recording import Measurement
from estimation.watch.limits import limits_of
from estimation.watch.livelier import MotionLevels
from estimation.watch.past import Anchor, Past, PastRow
from estimation.watch.replay import Replays
from estimation.watch.statistics import Statistics
from models.arrays import Array
from tests.estimation.watch.test_watched import AT_S, changed, clean, model, watched


def replays() -> Replays:
    return Replays(model(), MotionLevels(Ekf(model())), Statistics(model(), limits_of(model())))


@pytest.mark.parametrize("is_stuck", [False, True])
def test_it_is_made_without_who_was_left_out(is_stuck: bool) -> None:
    def lie(values: Array) -> Array:
        return np.tile(values[:1], (len(values), 1)) if is_stuck else values * [-1, 1, 1]

    time_s, y = changed("gyro", 1.5, lie).stacked(model())
    now = time_s <= AT_S + 1.2
    state, means = watched().init(), list[Array]()
    for t, row in zip(time_s[now], y[now], strict=True):
        state, estimate = watched().step(state, Measurement(float(t), row))
        means.append(estimate.state.mean)
    gyro = [sensor.name for sensor in model().sensors].index("gyro")
    assert gyro in state.left_out
    for back in (5, 20):
        number = state.past.count - back
        assert gyro in state.past.since(number)[0].out
        known = replays().before(state.past, state.level, number).gaussian
        assert known is not None
        np.testing.assert_array_equal(known.mean, means[number - 1])


def test_a_reading_that_repeats_itself_is_never_used() -> None:
    row = PastRow(0.0, np.zeros(1), frozenset({0}), stuck=frozenset({1}), out=frozenset({2}))
    assert row.unused == {0, 1, 2}


def test_in_front_of_the_oldest_anchor_is_the_first_row_that_has_one_before_it() -> None:
    time_s, y = clean().stacked(model())
    inner = Ekf(model()).batch(Ekf(model()).init(), time_s[:5], y[:5])[0]
    rows = tuple(
        PastRow(float(t), row, frozenset()) for t, row in zip(time_s[5:9], y[5:9], strict=True)
    )
    past = Past((Anchor(5, inner, float(time_s[4])),), rows)
    for number in (2, 5, 6):
        assert replays().before(past, 0, number).number == 6
