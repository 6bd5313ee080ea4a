"""Magnetometers, tips and several IMUs in other people's tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import pen_mhe as pm
from models.errors import InputError
from models.pen_file import load_pen
from recordings.read import read_written
from tests.compass import SENSORS, compass_pen, written
from tests.models.test_tip_position import TABLET, tablet_pen

MAGNETOMETERS: dict[str, tuple[tuple[str, str, str], float]] = {
    "one letter": (("mx", "my", "mz"), 1.0),
    "gauss by the field": (("magX", "magY", "magZ"), 0.01),
    "milligauss": (("Mag X (mG)", "Mag Y (mG)", "Mag Z (mG)"), 10.0),
    "gauss": (("Mag_x [G]", "Mag_y [G]", "Mag_z [G]"), 0.01),
    "microtesla": (tuple(f"Magnetic field {a} (µT)" for a in "xyz"), 1.0),  # type: ignore[dict-item]
    "ROS": (tuple(f"magnetic_field.{a}" for a in "xyz"), 1e-6),  # type: ignore[dict-item]
    "nanotesla": (("mag_x_nT", "mag_y_nT", "mag_z_nT"), 1e3),
    "tesla": (tuple(f"Magnetometer {a} (T)" for a in "xyz"), 1e-6),  # type: ignore[dict-item]
    "our own": (("mag_x_ut", "mag_y_ut", "mag_z_ut"), 1.0),
    "our own in mgauss": (("mag_x_mgauss", "mag_y_mgauss", "mag_z_mgauss"), 10.0),
    "compass": (("compass_x", "compass_y", "compass_z"), 10.0),
    "German": (("Magnetfeld X", "Magnetfeld Y", "Magnetfeld Z"), 1.0),
}
IMU = (("ax", "ay", "az"), ("gx", "gy", "gz"))


def table_of(recording: pm.Recording, headers: dict[str, tuple[Any, float]]) -> pd.DataFrame:
    columns = {"millis": 1e3 * recording.time_s}
    for sensor, (names, factor) in headers.items():
        columns |= dict(zip(names, factor * recording.readings[sensor].T, strict=True))
    return pd.DataFrame(columns)


@pytest.mark.parametrize("case", MAGNETOMETERS)
def test_a_magnetometer_in_any_unit(tmp_path: Path, case: str) -> None:
    recording = written(1, 3.0)
    headers = {"accel": (IMU[0], 1.0), "gyro": (IMU[1], 1.0), "mag": MAGNETOMETERS[case]}
    table_of(recording, headers).to_csv(tmp_path / "it.csv", index=False)
    read = read_written(tmp_path / "it.csv", compass_pen()).recording
    assert set(read.readings) == set(SENSORS)
    for sensor in SENSORS:
        np.testing.assert_allclose(
            read.readings[sensor], recording.readings[sensor], rtol=0, atol=1e-9
        )


def test_xsens_writes_one_for_the_field(tmp_path: Path) -> None:
    """Of any other logger a norm of one is in gauss, of Xsens too where it is 0.48."""
    recording = written(1, 3.0)
    strength = compass_pen().sensors["mag"].field_strength
    for per_ut, stamps, unit in (
        (1 / strength, "SampleTimeFine", strength),
        (0.01, "SampleTimeFine", 100.0),
        (1 / strength, "micros", 100.0),
    ):
        headers = {
            "accel": (("Acc_X", "Acc_Y", "Acc_Z"), 1.0),
            "gyro": (("Gyr_X", "Gyr_Y", "Gyr_Z"), 1.0),
            "mag": (("Mag_X", "Mag_Y", "Mag_Z"), per_ut),
        }
        table = table_of(recording, headers).rename(columns={"millis": stamps})
        table[stamps] = np.round(table[stamps] * (10 if stamps == "SampleTimeFine" else 1000))
        table.to_csv(tmp_path / "it.csv", index=False)
        read = read_written(tmp_path / "it.csv", compass_pen()).recording
        wanted = recording.readings["mag"] * per_ut * unit
        np.testing.assert_allclose(read.readings["mag"], wanted, rtol=1e-9)


def test_a_unit_that_is_asked_for(tmp_path: Path) -> None:
    recording, path = written(1, 3.0), tmp_path / "it.csv"
    headers = {"accel": (IMU[0], 1.0), "gyro": (IMU[1], 1.0), "mag": (("u", "v", "w"), 10.0)}
    table_of(recording, headers).to_csv(path, index=False)
    columns = {"mag": ("u", "v", "w")}
    for unit in ("mG", "mgauss", "gauss/1000"):
        read = read_written(path, compass_pen(), columns=columns, units={"mag": unit}).recording
        np.testing.assert_allclose(read.readings["mag"], recording.readings["mag"], atol=1e-9)
    with pytest.raises(InputError, match="expected ut or t or"):
        read_written(path, compass_pen(), columns=columns, units={"mag": "deg_s"})


def test_without_a_magnetometer_on_the_pen_it_is_ignored(tmp_path: Path) -> None:
    recording = written(1, 3.0)
    headers = {"accel": (IMU[0], 1.0), "gyro": (IMU[1], 1.0), "mag": (("mx", "my", "mz"), 1.0)}
    table_of(recording, headers).to_csv(tmp_path / "it.csv", index=False)
    found = read_written(tmp_path / "it.csv", load_pen("reference"))
    assert set(found.recording.readings) == {"accel", "gyro"}
    assert any("ignored: mx, my, mz" in note for note in found.notes)


@pytest.mark.parametrize(
    ("names", "factor"),
    [
        (("tip_x", "tip_y"), 1.0),
        (("pos_x_mm", "pos_y_mm"), 1e3),
        (("Stylus X", "Stylus Y"), 1e3),
        (("position x (cm)", "position y (cm)"), 100.0),
    ],
)
def test_a_tip_on_a_tablet(tmp_path: Path, names: tuple[str, str], factor: float) -> None:
    pen, sensors = tablet_pen(**TABLET), ("accel", "gyro", "tablet")
    recording = pm.simulate(pen, sensors, motion="handwriting", duration_s=3.0, seed=1)
    headers = {"accel": (IMU[0], 1.0), "gyro": (IMU[1], 1.0), "tablet": (names, factor)}
    table_of(recording, headers).to_csv(tmp_path / "it.csv", index=False)
    read = read_written(tmp_path / "it.csv", pen).recording
    np.testing.assert_allclose(
        read.readings["tablet"], recording.readings["tablet"], rtol=0, atol=1e-12
    )


def two_imus() -> pm.PenConfig:
    """Return a pen with an IMU near its tip and another, turned and slower, at its top."""
    reference, sensors = load_pen("reference"), dict[str, Any]()
    for place, z, turn in (
        ("lower", 0.03, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        ("upper", 0.13, [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
    ):
        for kind in ("accel", "gyro"):
            keys = {
                "position_m": (0.0, 0.003, z),
                "sensor_to_body": tuple(map(tuple, turn)),
                "rate_hz": 50.0 if place == "upper" else 100.0,
                "usual_innovations": None,
            }
            sensors[f"{kind}_{place}"] = reference.sensors[kind].model_copy(update=keys)
    sensors["rest"] = reference.sensors["rest"]
    return reference.model_copy(update={"sensors": sensors})


TWO = ("accel_lower", "gyro_lower", "accel_upper", "gyro_upper")
CHIPS: dict[str, dict[str, str]] = {
    "numbers": {
        "accel_lower": "a{}1", "gyro_lower": "g{}1", "accel_upper": "a{}2", "gyro_upper": "g{}2"
    },
    "words": {name: f"{name.split('_')[1]} {name[:3]} {{}}" for name in TWO},
    "numbers, the second first": {
        "accel_upper": "IMU2_acc_{}", "accel_lower": "IMU1_acc_{}",
        "gyro_lower": "IMU1_gyr_{}", "gyro_upper": "IMU2_gyr_{}",
    },
    "other words": {
        "gyro_lower": "front gyro {}", "accel_lower": "front accel {}",
        "accel_upper": "back accel {}", "gyro_upper": "back gyro {}",
    },
}  # fmt: skip
"""Case → sensor → its headers, in the file's order."""


@pytest.mark.parametrize("case", CHIPS)
def test_two_imus(tmp_path: Path, case: str) -> None:
    pen = two_imus()
    recording = pm.simulate(pen, TWO, motion="handwriting", duration_s=5.0, seed=2)
    headers = {
        sensor: (tuple(pattern.format(axis) for axis in "xyz"), 1.0)
        for sensor, pattern in CHIPS[case].items()
    }
    table_of(recording, headers).to_csv(tmp_path / "it.csv", index=False)
    found = read_written(tmp_path / "it.csv", pen)
    for sensor in TWO:
        np.testing.assert_allclose(
            found.recording.readings[sensor], recording.readings[sensor], rtol=0, atol=1e-12
        )
    assert not any("gyro" in note and "assumed" in note for note in found.notes)


def test_two_imus_in_two_files(tmp_path: Path) -> None:
    pen = two_imus()
    recording = pm.simulate(pen, TWO, motion="handwriting", duration_s=5.0, seed=2)
    paths = []
    for place in ("upper", "lower"):
        one = recording.select([f"accel_{place}", f"gyro_{place}"])
        headers = {f"accel_{place}": (IMU[0], 1.0), f"gyro_{place}": (IMU[1], 1.0)}
        paths.append(tmp_path / f"imu_{place}.csv")
        table_of(one, headers).dropna().to_csv(paths[-1], index=False)
    read = read_written(paths, pen).recording
    for sensor in TWO:
        theirs, ours = read.sensor(sensor), recording.sensor(sensor)
        np.testing.assert_allclose(theirs[0], ours[0], atol=1e-9)
        np.testing.assert_allclose(theirs[1], ours[1], rtol=0, atol=1e-12)


@pytest.mark.slow
def test_two_imus_are_estimated_with(tmp_path: Path) -> None:
    """From the foreign file to a tilt that both tell better than one."""
    pen, path = two_imus(), tmp_path / "it.csv"
    recording = pm.simulate(pen, TWO, motion="handwriting", duration_s=8.0, seed=2)
    headers = {
        sensor: (tuple(pattern.format(axis) for axis in "xyz"), 1.0)
        for sensor, pattern in CHIPS["numbers, the second first"].items()
    }
    table_of(recording, headers).to_csv(path, index=False)
    both = pm.estimate(path, pen=pen, estimator="mhe-rti").output
    one = pm.estimate(path, pen=pen, sensors=TWO[:2], estimator="mhe-rti").output
    assert recording.truth is not None
    for history in (both, one):
        true = recording.truth.states(["elevation_rad"], history.time_s)[:, 0]
        error = np.abs(history.column("elevation_rad") - true)[history.time_s > 1]
        assert (error < 4 * history.std_of("elevation_rad")[history.time_s > 1]).mean() > 0.99
    assert both.std_of("elevation_rad")[-1] < one.std_of("elevation_rad")[-1]
    assert not (both.flagged != 0).any()
