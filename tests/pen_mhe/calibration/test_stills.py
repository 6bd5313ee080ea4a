"""What counts as still: by spread, by abruptness, and what creeps or turns does not."""

from __future__ import annotations

import numpy as np
import pytest

import pen_mhe as pm
from models.errors import InputError
from models.sensor_kinds.inertial import InertialSensor
from pen_mhe.calibration.stills import MARGIN_S, Stills, find_stills
from tests.pen_mhe.calibration.poses import (
    FORCE_STD,
    GRAVITY,
    RATE_STD,
    STEP_S,
    TURN_S,
    TWENTY,
    Array,
    board,
    board_pen,
)

TIME_S = STEP_S * np.arange(1200)
LONG = 12.0


def inertial(**keys: object) -> dict[str, InertialSensor]:
    found = board_pen(**keys).sensors.items()
    return {name: sensor for name, sensor in found if isinstance(sensor, InertialSensor)}


def readings(force: Array | float = 0.0, rate: Array | float = 0.0, seed: int = 0) -> pm.Recording:
    """Return twelve seconds of gravity along z with what is added (1200, 3)."""
    rng = np.random.default_rng(seed)
    accel = np.array([0, 0, GRAVITY]) + force + FORCE_STD * rng.standard_normal((len(TIME_S), 3))
    gyro = 0.01 + rate + RATE_STD * rng.standard_normal((len(TIME_S), 3))
    return pm.Recording.from_sensors("it", {"accel": (TIME_S, accel), "gyro": (TIME_S, gyro)})


def found(*recordings: pm.Recording, **keys: object) -> Stills:
    return find_stills(recordings, inertial(**keys))


def axis(values: Array) -> Array:
    """Return a signal on x (n, 3)."""
    return np.outer(values, [1.0, 0.0, 0.0])


def test_every_pose_is_found_and_nothing_of_a_turn() -> None:
    stills = found(board(0).recording)
    assert (len(stills.kept), stills.creeping, stills.turning) == (20, (), ())
    for i, still in enumerate(stills.kept):
        start = i * (3.0 + TURN_S)
        assert start + MARGIN_S - 1e-9 <= still.start_s <= start + 0.7
        assert start + 2.3 <= still.stop_s <= start + 3.0 - MARGIN_S + 1e-9
        assert still.rate_hz["accel"] == pytest.approx(1 / STEP_S)
        away = still.mean("accel") / np.linalg.norm(still.mean("accel")) - TWENTY[i]
        assert np.abs(away).max() < 0.15


def test_one_that_is_still_throughout_is_one_stretch() -> None:
    (still,) = found(readings()).kept
    assert (still.start_s, still.stop_s) == pytest.approx((MARGIN_S, LONG - MARGIN_S))
    assert len(still.readings["gyro"]) == pytest.approx(1180, abs=1)


@pytest.mark.parametrize("hz", [1.0, 3.0, 8.0])
def test_a_hand_that_trembles_all_the_time_is_never_still(hz: float) -> None:
    """Ten times the pen file's noise, and slow from reading to reading."""
    tremor = axis(20 * FORCE_STD * np.sin(2 * np.pi * hz * TIME_S))
    with pytest.raises(InputError, match=r"it has no still stretch of 1\.2 s, the longest is 0 s"):
        found(readings(tremor))


def test_a_loud_recording_says_how_loud_it_is() -> None:
    loud = axis(2.0 * np.random.default_rng(1).standard_normal(len(TIME_S)))
    message = r"in its quietest tenth accel x spreads by .* expected at most 20 times .* 0\.02 m/s²"
    with pytest.raises(InputError, match=message):
        found(readings(loud))


def test_a_louder_sensor_than_its_file_says_is_still() -> None:
    louder = 5 * FORCE_STD * np.random.default_rng(2).standard_normal((len(TIME_S), 3))
    assert found(readings(louder)).kept[0].duration_s > 11


def test_a_slow_tilt_creeps() -> None:
    """By 0.1 °/s from the third second on, less than the noise within a block."""
    tilt = GRAVITY * np.sin(np.radians(0.1) * np.maximum(TIME_S - 3, 0))
    with pytest.raises(InputError, match=r"it moves slowly from 0\.1 s .* its mean force creeps"):
        found(readings(axis(tilt)))
    assert found(readings(axis(tilt / 100))).creeping == ()
    # Beside others it is left out.
    beside = found(readings(axis(tilt)), readings(seed=1))
    assert (len(beside.kept), len(beside.creeping)) == (1, 1)


def test_a_bias_that_walks_as_the_file_says_does_not_creep() -> None:
    walk = 0.005
    steps = walk * np.sqrt(STEP_S) * np.random.default_rng(3).standard_normal((len(TIME_S), 3))
    walked = readings(np.cumsum(steps, axis=0))
    assert len(found(walked, bias_walk_m_s2_per_sqrt_s=walk).kept) == 1
    with pytest.raises(InputError, match="creeps"):
        found(walked)


def test_a_turn_about_the_vertical_is_none_of_the_others() -> None:
    turned = readings(rate=np.outer(np.ones(len(TIME_S)), [0, 0, np.radians(2)]))
    stills = found(readings(), readings(seed=1), turned)
    assert len(stills.kept) == 2
    assert stills.turning[0].mean("gyro")[2] > np.radians(1.9)
    fast = readings(rate=np.radians(50.0))
    with pytest.raises(InputError, match="rate is no bias"):
        found(fast)


def test_a_gap_or_a_range_ends_a_stretch() -> None:
    whole = readings()
    kept = (TIME_S < 5.1) | (TIME_S > 5.3)
    cut = pm.Recording("cut", TIME_S[kept], {k: v[kept] for k, v in whole.readings.items()})
    assert [still.start_s for still in found(cut).kept] == pytest.approx([0.1, 5.6])
    assert found(cut).kept[0].stop_s == pytest.approx(4.9)
    high = whole.readings["accel"].copy()
    high[600, 2] = 12.0
    clipped = pm.Recording("it", TIME_S, {**whole.readings, "accel": high})
    assert len(found(clipped, range_m_s2=12.0).kept) == 2


def test_readings_that_hardly_change_are_still() -> None:
    """A quantiser with steps far above the noise: a toggle is no slow motion."""
    coarse = readings()
    steps = {"accel": 0.1, "gyro": 0.02}
    rounded = {name: np.round(v / steps[name]) * steps[name] for name, v in coarse.readings.items()}
    stills = found(pm.Recording("it", TIME_S, rounded), resolution_m_s2=0.1)
    assert stills.kept[0].duration_s > 11
