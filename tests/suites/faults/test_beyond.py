"""Faults beyond the table: each hits what it says, from when it says, and a command counts them."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from models.arrays import Array
from suites.faults import beyond
from suites.faults.beyond import BeyondRun, table, wanted
from suites.faults.given_rows import GivenRows
from suites.faults.inject import injected
from suites.faults.kept_runs import kept
from suites.faults.protocol import faults_for, model_of, recorded, targets_of
from suites.faults.table import BEYOND, faults

SENSORS = "accel+gyro+camera"
SEED = 3
STAMPS = ("late", "clock_off")


@cache
def clean() -> GivenRows:
    return GivenRows.of(recorded(SENSORS, SEED, 8.0))


@cache
def hit(key: str) -> GivenRows:
    return injected(faults(BEYOND)[key], clean(), model_of(SENSORS), SEED)


def readings(key: str, sensor: str) -> tuple[Array, Array, Array]:
    """Stamps, readings without and with a fault, of a sensor from the fault's begin on."""
    time_s, before = clean().sensor(sensor)
    rows = clean().rows_of(sensor)
    after = hit(key).readings[sensor][rows]
    on = time_s >= faults(BEYOND)[key].at_s - 1e-9
    return time_s[on], before[on], after[on]


@pytest.mark.parametrize("key", faults(BEYOND))
def test_a_fault_changes_its_sensors_from_its_begin_on_and_nothing_else(key: str) -> None:
    fault = faults(BEYOND)[key]
    assert math.isinf(fault.end_s)
    found, of = hit(key), targets_of(model_of(SENSORS), fault.of)
    for name in clean().readings:
        time_s, before = clean().sensor(name)
        if fault.does in STAMPS:
            stamps, values = found.sensor(name)
            np.testing.assert_array_equal(values, before)
            moved = fault.size if fault.does == "late" else fault.size * time_s
            np.testing.assert_allclose(stamps - time_s, moved if name in of else 0.0, atol=1e-6)
            continue
        after = found.readings[name][clean().rows_of(name)]
        is_same = ((after == before) | (np.isnan(after) & np.isnan(before))).all(axis=1)
        if name in of:
            assert is_same[time_s < fault.at_s - 1e-9].all()
            assert not is_same[time_s >= fault.at_s - 1e-9].all()
        else:
            assert is_same.all()


def test_what_single_faults_do() -> None:
    t, before, after = readings("bias drifts, gyro, 3 deg/s, to the end", "gyro")
    np.testing.assert_allclose(after - before, np.outer(np.radians(3) * (t - 3), [1, 0, 0]))
    _, before, after = readings("gain of an axis, accel, y", "accel")
    np.testing.assert_allclose(after, before * [1.0, 1.1, 1.0])
    _, before, after = readings("axes swapped, accel, y, z, to the end", "accel")
    np.testing.assert_array_equal(after, before[:, [0, 2, 1]])
    _, before, after = readings("axis lost, gyro, z, to the end", "gyro")
    assert np.isnan(after[:, 2]).all()
    np.testing.assert_array_equal(after[:, :2], before[:, :2])
    t, before, after = readings("low-pass, gyro, 2", "gyro")
    a = 1 - np.exp(-2 * np.pi * 2 * np.diff(t).mean())
    state = (1 - a) * before[:1]
    filtered = lfilter([a], [1, a - 1], before, axis=0, zi=state)[0]
    np.testing.assert_allclose(after, filtered, atol=1e-4)
    t, before, after = readings("camera moved, camera, 5 mm/s, to the end", "camera")
    np.testing.assert_allclose(after - before, np.outer(5e-3 * (t - 3), np.eye(6)[0]), atol=1e-12)
    t, before, after = readings("turned, camera, 10 deg about z, to the end", "camera")
    turned = Rotation.from_rotvec(after[:, 3:]) * Rotation.from_rotvec(before[:, 3:]).inv()
    np.testing.assert_allclose(turned.as_rotvec(degrees=True), [[0, 0, 10.0]] * len(t), atol=1e-9)
    _, before, after = readings("frames held, camera, 3, to the end", "camera")
    np.testing.assert_array_equal(after[::3], before[::3])
    np.testing.assert_array_equal(after[2::3], before[::3][: len(after[2::3])])


def test_what_packets_do() -> None:
    _, before, after = readings("packet repeated, gyro, 0.2, to the end", "gyro")
    n = round(0.2 * 100)
    np.testing.assert_array_equal(after[n : 2 * n], before[:n])
    np.testing.assert_array_equal(after[2 * n : 3 * n], before[2 * n : 3 * n])
    _, before, after = readings("packet reversed, gyro, 0.1, to the end", "gyro")
    np.testing.assert_array_equal(after[:10], before[9::-1])
    _, _, after = readings("bursts lost, imu, to the end", "accel")
    assert 0.3 < np.isnan(after).all(axis=1).mean() < 0.7


def test_what_was_done_by_the_same_build_is_not_done_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, done = tmp_path / "beyond.jsonl", list[BeyondRun]()

    def fake(run: BeyondRun) -> BeyondRun:
        done.append(run)
        return replace(run, is_silent="drifts" in run.fault, silent_s=0.5)

    given = ["-", "--seeds", "2", "--sensors", "accel+gyro", "--output", str(path)]
    monkeypatch.setattr(sys, "argv", given)
    monkeypatch.setattr(beyond, "scored", fake)
    monkeypatch.setattr(beyond, "code_identity", lambda: "one")
    beyond.main()
    beyond.main()
    assert done == list(wanted("one", ["ekf"], ["accel+gyro"], 2))
    assert len(done) == 2 * len(faults_for("accel+gyro", BEYOND))
    printed = capsys.readouterr().out
    assert f"ekf: silent 10 of {len(done)} runs" in printed
    assert "    2 bias drifts, accel, 0.5 m/s², to the end (accel+gyro)" in printed
    assert table(kept(path, BeyondRun)) in printed
