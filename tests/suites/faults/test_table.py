"""The table of faults: every row is there, with the words and figures that were asked for."""

from __future__ import annotations

import math

import pytest

from suites.faults.inject import INJECTIONS
from suites.faults.protocol import SENSORS, faults_for, model_of, targets_of
from suites.faults.table import BEYOND, FILE, fault_named, faults

ROWS = {
    "dropout": 15,
    "hole in time, no instants at all": 2,
    "stuck at the last reading": 4,
    "five spikes, 0.2 s apart, axes in turn, signs alternating": 4,
    "at the range limit": 1,
    "clipped at a share of the recording's largest reading, limit not in the pen file": 2,
    "bias step on the first axis": 3,
    "bias step of the gyroscope for a second": 1,
    "scale of 5 % all along": 2,
    "stamps jitter, uniform ± ms, sorted": 2,
    "stamps of the IMU 45 ms late against the camera, all along": 1,
    "every sample twice: same stamp; half a period later": 2,
    "neighbours swapped: with their stamps; readings only": 2,
    "another unit mid-way: gyro in deg/s, gyro divided by 57.3, accel in g": 3,
    "axis flipped: accel x, gyro x for a second; accel y, gyro y all along": 4,
    "one pose 0.5 m and 90 deg off; 10 % of the poses 50 mm and 30 deg off for 2 s": 2,
    "quaternion of the other sign every second frame (no fault at all); conjugated for 2 s": 2,
    "switched on in motion, at 1.37 s": 1,
    "sampled at 1 Hz all along": 1,
}
"""Row of the table that was asked for → how many faults are in it."""


def test_nothing_was_thinned_out() -> None:
    found = [fault.name for fault in faults().values()]
    assert {name: found.count(name) for name in dict.fromkeys(found)} == ROWS


def test_every_fault_is_done_by_something() -> None:
    done = {fault.does for file in (FILE, BEYOND) for fault in faults(file).values()}
    assert done == set(INJECTIONS)


@pytest.mark.parametrize(
    ("key", "at_s", "end_s", "duration_s"),
    [
        ("dropout, camera, 0.5 s", 3.0, 3.5, 8.0),
        ("hole, all, 10 s", 3.0, 13.0, 18.0),
        ("spikes, gyro, 3 rad/s", 3.0, 3.8, 8.0),
        ("clipped, gyro, 0.3, 2 s", 3.0, 5.0, 8.0),
        ("bias step, accel, 2 m/s², to the end", 3.0, math.inf, 8.0),
        ("scale 5 %, gyro", 0.0, math.inf, 8.0),
        ("poses off, camera, one", 3.0, 3.0, 8.0),
        ("switched on in motion, all", 1.37, 1.37, 8.0),
    ],
)
def test_when_it_lasts(key: str, at_s: float, end_s: float, duration_s: float) -> None:
    fault = fault_named(key)
    assert (fault.at_s, fault.duration_s) == (at_s, duration_s)
    assert fault.end_s == pytest.approx(end_s)
    assert fault.stays == math.isinf(end_s)
    assert fault.over_s == pytest.approx(at_s if math.isinf(end_s) else end_s)


def test_sizes_are_in_si() -> None:
    assert fault_named("bias step, gyro, 30 deg/s, 1 s").size == pytest.approx(0.523599, rel=1e-6)
    assert fault_named("jitter, all, 4 ms, 2 s").size == pytest.approx(4e-3)
    assert fault_named("unit, accel, g, 1 s").size == pytest.approx(1 / 9.80665)


@pytest.mark.parametrize(
    ("sensors", "target", "names"),
    [
        ("accel+gyro", "imu", ("accel", "gyro")),
        ("accel+gyro+camera", "all", ("accel", "gyro", "camera")),
        ("accel+gyro", "camera", ()),
        ("two accelerometers", "accel", ("accel_lower",)),
        ("two accelerometers+camera", "imu", ("accel_lower", "accel_upper")),
        ("two accelerometers", "gyro", ()),
    ],
)
def test_what_a_target_means(sensors: str, target: str, names: tuple[str, ...]) -> None:
    assert targets_of(model_of(sensors), target) == names


def test_every_choice_of_sensors_has_what_it_can_have_once() -> None:
    counts = {sensors: len(faults_for(sensors)) for sensors in SENSORS}
    assert counts == {
        "accel+gyro": 42,
        "accel+gyro+camera": 54,
        "two accelerometers": 28,
        "two accelerometers+camera": 40,
    }
    assert {fault.key for fault in faults_for("accel+gyro+camera")} == set(faults())
    keys = {fault.key for fault in faults_for("accel+gyro")}
    assert "dropout, imu, 2 s" in keys
    assert "dropout, all, 2 s" not in keys  # where there is no camera the IMU is all
    assert "stamps 45 ms late, imu" not in keys  # against which nothing is late
