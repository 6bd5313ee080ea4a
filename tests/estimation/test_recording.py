"""Recordings: the union of all stamps, nothing moved, bad input refused in one sentence."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.recording import Recording, Truth
from models.errors import InputError

NAN = np.nan


def small() -> Recording:
    return Recording.from_sensors(
        "small",
        {
            "accel": (np.array([0.0, 0.1, 0.2, 0.3]), np.arange(8.0).reshape(4, 2)),
            "camera": (np.array([0.05, 0.2]), np.array([[10.0], [20.0]])),
        },
        truth=Truth(np.array([0.0]), ("tip_x_m",), np.zeros((1, 1))),
    )


def one_sentence(error: InputError) -> bool:
    """No line break and no full stop inside: one sentence."""
    return re.search(r"\n|\.\s", str(error)) is None


stamps = st.lists(st.integers(0, 10**12), min_size=1, max_size=20, unique=True)


@settings(max_examples=50, deadline=None)
@given(stamps, stamps)
def test_every_reading_is_found_at_its_own_stamp(first: list[int], second: list[int]) -> None:
    """Stamps in nanoseconds, in any order, of two sensors."""
    sensors = {}
    for name, ticks in (("a", first), ("b", second)):
        times = np.array(ticks) * 1e-9
        sensors[name] = (times, np.column_stack([times, np.arange(len(ticks))]))
    recording = Recording.from_sensors("union", sensors)
    assert len(recording.time_s) == len({*first, *second})
    assert (np.diff(recording.time_s) > 0).all()
    for name, (times, values) in sensors.items():
        found = recording.readings[name]
        assert (~np.isnan(found).any(axis=1)).sum() == len(times)
        for time_s, value in zip(times, values, strict=True):
            row = int(np.argmin(np.abs(recording.time_s - time_s)))
            assert abs(recording.time_s[row] - time_s) < 1e-9
            np.testing.assert_array_equal(found[row], value)


def test_union_of_stamps_in_full() -> None:
    recording = small()
    np.testing.assert_array_equal(recording.time_s, [0.0, 0.05, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(
        recording.readings["accel"], [[0, 1], [NAN, NAN], [2, 3], [4, 5], [6, 7]]
    )
    np.testing.assert_array_equal(recording.readings["camera"], [[NAN], [10], [NAN], [20], [NAN]])


@pytest.mark.parametrize(
    ("times", "row"),
    [
        ([0.0, 1.0, 1.0, 2.0], 2),
        ([0.0, 1.0, 0.5, 2.0], 2),
        ([0.0, NAN, 1.0, 2.0], 1),
        ([0.0, 1.0, 2.0, np.inf], 3),
        ([-np.inf, 0.0, 1.0, 2.0], 0),
    ],
)
def test_a_bad_time_is_refused_with_its_row(times: list[float], row: int) -> None:
    with pytest.raises(InputError, match=rf"row {row}\b") as caught:
        Recording("bad", np.array(times), {"accel": np.zeros((4, 1))})
    assert one_sentence(caught.value)


def test_an_infinite_reading_is_refused_with_its_row() -> None:
    values = np.zeros((3, 2))
    values[2, 0] = -np.inf
    with pytest.raises(InputError, match=r"accel in row 2") as caught:
        Recording("bad", np.arange(3.0), {"accel": values})
    assert one_sentence(caught.value)


@pytest.mark.parametrize("bad", [NAN, np.inf])
def test_a_bad_time_of_a_sensor_is_refused(bad: float) -> None:
    times = np.array([0.0, bad, 0.2])
    with pytest.raises(InputError, match="not finite"):
        Recording.from_sensors("bad", {"accel": (times, np.zeros((3, 1)))})


def test_a_sensor_with_two_readings_at_one_time_is_refused() -> None:
    times = np.array([0.0, 0.1, 0.1])
    with pytest.raises(InputError, match=r"accel has two readings at 0\.1 s") as caught:
        Recording.from_sensors("bad", {"accel": (times, np.zeros((3, 1)))})
    assert one_sentence(caught.value)


@pytest.mark.parametrize("n_values", [1, 2, 4])
def test_times_and_values_of_different_length_are_refused(n_values: int) -> None:
    """NumPy would spread a single reading over all stamps in silence."""
    with pytest.raises(InputError, match="accel"):
        Recording.from_sensors("bad", {"accel": (np.arange(3.0), np.ones((n_values, 2)))})


def test_values_that_are_no_table_are_refused() -> None:
    with pytest.raises(InputError, match="accel"):
        Recording.from_sensors("bad", {"accel": (np.arange(3.0), np.ones((3, 1, 1)))})
    with pytest.raises(InputError, match="accel"):
        Recording("bad", np.arange(3.0), {"accel": np.ones((3, 1, 1))})
    with pytest.raises(InputError, match="accel"):
        Recording("bad", np.arange(3.0), {"accel": np.ones((2, 1))})


def test_an_empty_recording_is_refused() -> None:
    with pytest.raises(InputError, match="empty"):
        Recording("nothing", np.zeros(0), {})
    with pytest.raises(InputError, match="empty"):
        Recording.from_sensors("nothing", {})


def test_sensor_returns_its_own_readings() -> None:
    times, values = small().sensor("camera")
    np.testing.assert_array_equal(times, [0.05, 0.2])
    np.testing.assert_array_equal(values, [[10.0], [20.0]])


def test_select_keeps_a_sensor_and_drops_the_instants_of_the_others() -> None:
    recording = small()
    selected = recording.select(["camera"])
    assert list(selected.readings) == ["camera"]
    np.testing.assert_array_equal(selected.time_s, [0.05, 0.2])
    assert selected.truth is recording.truth


@pytest.mark.parametrize("phase", [0, 1, 2])
def test_subsampled_keeps_every_third_and_the_other_sensor(phase: int) -> None:
    times = np.arange(10) * 0.1
    recording = Recording.from_sensors(
        "r", {"accel": (times, times[:, None]), "camera": (times + 0.03, times[:, None])}
    )
    thinned = recording.subsampled("accel", every=3, phase=phase)
    kept_times, kept_values = thinned.sensor("accel")
    np.testing.assert_array_equal(kept_values[:, 0], times[phase::3])
    np.testing.assert_allclose(kept_times, times[phase::3], rtol=0, atol=1e-9)
    assert len(thinned.sensor("camera")[0]) == 10


def test_first_keeps_a_duration() -> None:
    shortened = small().first(0.1)
    np.testing.assert_array_equal(shortened.time_s, [0.0, 0.05, 0.1])
    np.testing.assert_array_equal(shortened.readings["accel"], [[0, 1], [NAN, NAN], [2, 3]])


@pytest.mark.parametrize(
    "use",
    [
        lambda r: r.sensor("gyro"),
        lambda r: r.select(["accel", "gyro"]),
        lambda r: r.subsampled("gyro", 2, 0),
    ],
    ids=["sensor", "select", "subsampled"],
)
def test_an_unknown_sensor_is_refused_by_name(use: Callable[[Recording], object]) -> None:
    with pytest.raises(InputError, match=r"gyro.*accel") as caught:
        use(small())
    assert one_sentence(caught.value)


def test_a_prompt_shows_what_is_in_it() -> None:
    truth = Truth(np.arange(3.0), ("a_m", "b_m"), np.zeros((3, 2)))
    readings = {"gyro": np.array([[1.0], [np.nan], [2.0]]), "accel": np.zeros((3, 2))}
    recording = Recording("loop", np.arange(3.0), readings, truth)
    sentence = "<Recording loop: 0 s to 2 s, readings: gyro 2, accel 3, truth of 2 states>"
    assert repr(recording) == sentence
