"""Every fault changes what it says, and nothing else: an independent look at each."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.arrays import Array
from suites.faults.given_rows import GivenRows
from suites.faults.inject import injected
from suites.faults.protocol import model_of, recorded
from suites.faults.table import fault_named, faults

SENSORS = "accel+gyro+camera"
G = 9.80665
SEED = 3


@cache
def clean(duration_s: float = 8.0) -> GivenRows:
    return GivenRows.of(recorded(SENSORS, SEED, duration_s))


@cache
def hit(key: str) -> GivenRows:
    fault = fault_named(key)
    return injected(fault, clean(fault.duration_s), model_of(SENSORS), SEED)


def axis(number: int, change: Callable[[Any], Any]) -> Callable[[Array], Array]:
    def changed(values: Array) -> Array:
        found = values.copy()
        found[:, number] = change(found[:, number])
        return found

    return changed


def largest(sensor: str) -> float:
    return float(np.nanmax(np.abs(clean().readings[sensor])))


def at_limit(limit: float) -> Callable[[Array], Array]:
    return lambda values: np.sign(values) * limit


WITHIN: dict[str, tuple[float, float, dict[str, Callable[[Array], Array]]]] = {
    **{
        f"dropout, {target}, {length:g} s": (
            3.0,
            3.0 + length,
            {name: lambda values: values * np.nan for name in names},
        )
        for target, names in {
            "imu": ("accel", "gyro"),
            "gyro": ("gyro",),
            "accel": ("accel",),
            "camera": ("camera",),
            "all": ("accel", "gyro", "camera"),
        }.items()
        for length in (0.1, 0.5, 2.0)
    },
    "range limit, imu, 0.5 s": (
        3.0,
        3.5,
        {"accel": at_limit(4 * G), "gyro": at_limit(np.radians(245.0))},
    ),
    "clipped, accel, 0.8, 1 s": (
        3.0,
        4.0,
        {"accel": lambda values: np.minimum(np.abs(values), 0.8 * largest("accel"))
         * np.sign(values)},
    ),
    "clipped, gyro, 0.3, 2 s": (
        3.0,
        5.0,
        {"gyro": lambda values: np.minimum(np.abs(values), 0.3 * largest("gyro"))
         * np.sign(values)},
    ),
    "bias step, accel, 0.5 m/s², to the end": (3.0, 99.0, {"accel": axis(0, lambda a: a + 0.5)}),
    "bias step, accel, 2 m/s², to the end": (3.0, 99.0, {"accel": axis(0, lambda a: a + 2)}),
    "bias step, gyro, 5 deg/s, to the end": (
        3.0, 99.0, {"gyro": axis(0, lambda a: a + np.radians(5))}
    ),
    "bias step, gyro, 30 deg/s, 1 s": (3.0, 4.0, {"gyro": axis(0, lambda a: a + np.radians(30))}),
    "scale 5 %, imu": (0.0, 99.0, dict.fromkeys(("accel", "gyro"), lambda values: 1.05 * values)),
    "scale 5 %, gyro": (0.0, 99.0, {"gyro": lambda values: 1.05 * values}),
    "unit, gyro, deg/s, 1 s": (3.0, 4.0, {"gyro": np.degrees}),
    "unit, gyro, divided by 57.3, 1 s": (3.0, 4.0, {"gyro": np.radians}),
    "unit, accel, g, 1 s": (3.0, 4.0, {"accel": lambda values: values / G}),
    "flipped, accel, x, 1 s": (3.0, 4.0, {"accel": axis(0, np.negative)}),
    "flipped, gyro, x, 1 s": (3.0, 4.0, {"gyro": axis(0, np.negative)}),
    "flipped, accel, y all along": (0.0, 99.0, {"accel": axis(1, np.negative)}),
    "flipped, gyro, y all along": (0.0, 99.0, {"gyro": axis(1, np.negative)}),
    "quaternion, camera, conjugated, 2 s": (
        3.0,
        5.0,
        {"camera": lambda values: np.hstack([values[:, :3], -values[:, 3:]])},
    ),
}  # fmt: skip
"""Faults that do the same to every reading within a time → from, until, sensor → what."""


@pytest.mark.parametrize("key", WITHIN)
def test_readings_within_a_time(key: str) -> None:
    at_s, end_s, changes = WITHIN[key]
    before, after = clean(), hit(key)
    np.testing.assert_array_equal(after.time_s, before.time_s)
    within = (before.time_s > at_s - 1e-6) & (before.time_s < end_s - 1e-6)
    for name, values in before.readings.items():
        expected = values.copy()
        if name in changes:
            expected[within] = changes[name](values[within])
            assert not np.array_equal(expected, values, equal_nan=True)
        np.testing.assert_allclose(after.readings[name], expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize("name", ["accel", "gyro", "camera"])
def test_stuck_repeats_the_last_reading_before(name: str) -> None:
    time_s, before = clean().sensor(name)
    after = hit(f"stuck, {name}, 1 s").sensor(name)[1]
    stuck = (time_s >= 3.0) & (time_s < 3.99999)
    last = before[np.flatnonzero(time_s < 3.0)[-1]]
    assert (after[stuck] == last).all()
    np.testing.assert_array_equal(after[~stuck], before[~stuck])
    for other in {"accel", "gyro", "camera"} - {name}:
        same = hit(f"stuck, {name}, 1 s").readings[other]
        np.testing.assert_array_equal(same, clean().readings[other])


def test_a_stuck_imu_is_both() -> None:
    for name in ("accel", "gyro"):
        np.testing.assert_array_equal(
            hit("stuck, imu, 1 s").readings[name], hit(f"stuck, {name}, 1 s").readings[name]
        )


@pytest.mark.parametrize(
    ("key", "name", "size"),
    [
        ("spikes, accel, 20 m/s²", "accel", 20.0),
        ("spikes, accel, 10000 m/s²", "accel", 1e4),
        ("spikes, gyro, 3 rad/s", "gyro", 3.0),
        ("spikes, gyro, 1000 rad/s", "gyro", 1e3),
    ],
)
def test_five_spikes(key: str, name: str, size: float) -> None:
    change = np.nan_to_num(hit(key).readings[name] - clean().readings[name])
    rows, axes = np.nonzero(change)
    np.testing.assert_allclose(clean().time_s[rows], [3.0, 3.2, 3.4, 3.6, 3.8])
    assert axes.tolist() == [0, 1, 2, 0, 1]
    np.testing.assert_allclose(change[rows, axes], size * np.array([1, -1, 1, -1, 1]))


@pytest.mark.parametrize(("length", "last"), [(2.0, 8.0), (10.0, 18.0)])
def test_a_hole_has_no_instants(length: float, last: float) -> None:
    before, after = clean(last), hit(f"hole, all, {length:g} s")
    kept = (before.time_s < 3.0) | (before.time_s > 3.0 + length - 1e-6)
    np.testing.assert_array_equal(after.time_s, before.time_s[kept])
    assert after.time_s[-1] == last
    for name, values in before.readings.items():
        np.testing.assert_array_equal(after.readings[name], values[kept])


def test_switched_on_in_motion() -> None:
    before, after = clean(), hit("switched on in motion, all")
    assert after.time_s[0] == pytest.approx(1.37)
    np.testing.assert_array_equal(after.time_s, before.time_s[before.time_s > 1.3699])


@pytest.mark.parametrize(
    ("key", "most"), [("jitter, all, 1 ms, 2 s", 1e-3), ("jitter, all, 4 ms, 2 s", 4e-3)]
)
def test_jitter_moves_stamps_alone(key: str, most: float) -> None:
    before, after = clean(), hit(key)
    for name, values in before.readings.items():
        np.testing.assert_array_equal(after.readings[name], values)
    moved = after.time_s - before.time_s
    hit_rows = (before.time_s >= 3.0) & (before.time_s < 4.99999)
    assert (np.diff(after.time_s) >= 0).all()
    assert (moved[~hit_rows] == 0).all()
    # Sorting takes no stamp further from its place than the largest of them is.
    assert 0.8 * most < np.abs(moved[hit_rows]).max() <= most
    assert np.std(moved[hit_rows]) == pytest.approx(most / np.sqrt(3), rel=0.25)


def test_stamps_of_the_imu_are_late() -> None:
    before, after = clean(), hit("stamps 45 ms late, imu")
    for name, late_s in (("accel", 0.045), ("gyro", 0.045), ("camera", 0.0)):
        (time_s, values), (stamps, same) = before.sensor(name), after.sensor(name)
        np.testing.assert_allclose(stamps, time_s + late_s, atol=1e-9)
        np.testing.assert_array_equal(same, values)


def test_twice_under_the_same_stamp() -> None:
    before, after = clean(), hit("twice, all, same stamp, 1 s")
    expected = [t for t in before.time_s.tolist() for _ in range(2 if 3 <= t < 3.99999 else 1)]
    assert after.time_s.tolist() == expected
    for name in before.readings:
        first = np.flatnonzero(np.diff(after.time_s, prepend=-1.0) > 0)
        np.testing.assert_array_equal(after.readings[name][first], before.readings[name])
        again = np.setdiff1d(np.arange(len(expected)), first)
        np.testing.assert_array_equal(after.readings[name][again], after.readings[name][again - 1])


@pytest.mark.parametrize(
    ("name", "half_s"), [("accel", 0.005), ("gyro", 0.005), ("camera", 1 / 60)]
)
def test_twice_half_a_period_later(name: str, half_s: float) -> None:
    (time_s, values), (stamps, all_values) = (
        stream.sensor(name) for stream in (clean(), hit("twice, all, half a period later, 1 s"))
    )
    doubled = (time_s >= 3.0) & (time_s < 3.99999)
    order = np.argsort(np.append(time_s, time_s[doubled] + half_s), kind="stable")
    np.testing.assert_allclose(
        stamps, np.append(time_s, time_s[doubled] + half_s)[order], atol=1e-8
    )
    np.testing.assert_array_equal(all_values, np.vstack([values, values[doubled]])[order])


def test_neighbours_swapped_with_their_stamps() -> None:
    before, after = clean(), hit("swapped, all, with stamps, 1 s")
    rows = list(range(len(before.time_s)))
    first, last = np.flatnonzero((before.time_s >= 3.0) & (before.time_s < 3.99999))[[0, -1]]
    for k in range(first, last, 2):
        rows[k], rows[k + 1] = rows[k + 1], rows[k]
    np.testing.assert_array_equal(after.time_s, before.time_s[rows])
    for name, values in before.readings.items():
        np.testing.assert_array_equal(after.readings[name], values[rows])


@pytest.mark.parametrize("name", ["accel", "gyro", "camera"])
def test_neighbours_swapped_under_their_stamps(name: str) -> None:
    (time_s, values), (stamps, swapped) = (
        stream.sensor(name) for stream in (clean(), hit("swapped, all, readings only, 1 s"))
    )
    np.testing.assert_array_equal(stamps, time_s)
    expected = values.copy()
    first, last = np.flatnonzero((time_s >= 3.0) & (time_s < 3.99999))[[0, -1]]
    for k in range(first, last, 2):
        expected[[k, k + 1]] = values[[k + 1, k]]
    np.testing.assert_array_equal(swapped, expected)


def turned_deg(one: Array, other: Array) -> Array:
    turn = Rotation.from_rotvec(one[:, 3:]) * Rotation.from_rotvec(other[:, 3:]).inv()
    return np.degrees(turn.magnitude())


def test_one_pose_is_off() -> None:
    (time_s, values), (_, off) = (
        s.sensor("camera") for s in (clean(), hit("poses off, camera, one"))
    )
    (row,) = np.flatnonzero((off != values).any(axis=1))
    assert time_s[row] == pytest.approx(3.0)
    assert np.linalg.norm(off[row, :3] - values[row, :3]) == pytest.approx(0.5)
    assert turned_deg(off[[row]], values[[row]]) == pytest.approx(90)


def test_a_tenth_of_the_poses_is_off() -> None:
    found = []
    for seed in range(30):
        fault = fault_named("poses off, camera, 10 %, 2 s")
        after = injected(fault, clean(), model_of(SENSORS), seed)
        (time_s, values), (_, off) = (s.sensor("camera") for s in (clean(), after))
        rows = np.flatnonzero((off != values).any(axis=1))
        found.append(len(rows))
        assert ((time_s[rows] >= 3.0) & (time_s[rows] < 5.0)).all()
        np.testing.assert_allclose(np.linalg.norm(off[rows, :3] - values[rows, :3], axis=1), 0.05)
        np.testing.assert_allclose(turned_deg(off[rows], values[rows]), 30)
    assert np.mean(found) == pytest.approx(6, abs=1.5)  # of 60 frames
    assert len(set(found)) > 1


def test_the_quaternion_of_the_other_sign_is_the_same_attitude() -> None:
    (_, values), (_, other) = (
        stream.sensor("camera") for stream in (clean(), hit("quaternion, camera, other sign"))
    )
    np.testing.assert_array_equal(other[0::2], values[0::2])
    assert (np.abs(other[1::2, 3:] - values[1::2, 3:]).max(axis=1) > 1).all()
    np.testing.assert_allclose(turned_deg(other, values), 0, atol=1e-6)
    quaternions = [rotation_quaternion(v) for v in other[1::2, 3:]]
    plain = [rotation_quaternion(v) for v in values[1::2, 3:]]
    np.testing.assert_allclose(quaternions, -np.array(plain), atol=1e-12)
    np.testing.assert_array_equal(other[:, :3], values[:, :3])


def rotation_quaternion(vector: Array) -> Array:
    """w, x, y, z of a rotation vector, with the sign that its length gives it."""
    angle = float(np.linalg.norm(vector))
    return np.append(np.cos(angle / 2), np.sin(angle / 2) * vector / angle)


def test_a_reading_a_second() -> None:
    for name in clean().readings:
        (time_s, values), (stamps, kept) = (
            stream.sensor(name) for stream in (clean(), hit("1 Hz, all"))
        )
        np.testing.assert_allclose(stamps, np.arange(9.0), atol=1e-9)
        rows = [int(np.argmin(np.abs(time_s - second))) for second in range(9)]
        np.testing.assert_array_equal(kept, values[rows])


def test_every_fault_was_looked_at() -> None:
    apart = {
        *(f"stuck, {name}, 1 s" for name in ("imu", "accel", "gyro", "camera")),
        *("spikes, accel, 20 m/s²", "spikes, accel, 10000 m/s²"),
        *("spikes, gyro, 3 rad/s", "spikes, gyro, 1000 rad/s"),
        *("hole, all, 2 s", "hole, all, 10 s", "switched on in motion, all", "1 Hz, all"),
        *("jitter, all, 1 ms, 2 s", "jitter, all, 4 ms, 2 s", "stamps 45 ms late, imu"),
        *("twice, all, same stamp, 1 s", "twice, all, half a period later, 1 s"),
        *("swapped, all, with stamps, 1 s", "swapped, all, readings only, 1 s"),
        *("poses off, camera, one", "poses off, camera, 10 %, 2 s"),
        "quaternion, camera, other sign",
    }
    assert {*WITHIN, *apart} == set(faults())
