"""Samples of other people's files: every one that is a recording loads, with one option at most."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from models.errors import InputError
from models.pen_file import load_pen
from models.units import STANDARD_GRAVITY_M_S2 as G
from recordings.read import read_written

FOLDER = Path(os.environ.get("PEN_MHE_DATA", "no data")) / "foreign"
pytestmark = [
    pytest.mark.skipif(not FOLDER.is_dir(), reason="PEN_MHE_DATA names no folder with foreign/"),
    pytest.mark.filterwarnings("ignore::FutureWarning"),
]
WITHIN = {"accel": 0.011, "gyro": 0.0011}
"""Of readings with the digits of the coarsest file: 0.1 mg and 0.01 deg/s make less."""
CHANGED = {"accel_sign_flipped", "accel_stuck_after_6s", "gyro_sign_flipped", "nans"}
NAMES = (
    "accel_sign_flipped", "accel_stuck_after_6s", "arduino_mg_dps", "canonical",
    "duplicates_jitter", "extra_column_temperature", "german_semicolon", "gyro_sign_flipped",
    "header_spaces_case", "nans",
)  # fmt: skip


def pen() -> object:
    return load_pen(FOLDER / "pen_right_mounting.toml")


@pytest.mark.parametrize("name", NAMES)
def test_a_sample(name: str) -> None:
    found = read_written(FOLDER / f"{name}.csv", pen()).recording  # type: ignore[arg-type]
    plain = pd.read_csv(FOLDER / "canonical.csv").to_numpy()
    assert len(found.time_s) == len(plain)
    if name in CHANGED:
        return
    for sensor, columns in (("accel", slice(1, 4)), ("gyro", slice(4, 7))):
        _, values = found.sensor(sensor)
        np.testing.assert_allclose(values, plain[:, columns], atol=WITHIN[sensor])
    np.testing.assert_allclose(found.time_s - found.time_s[0], plain[:, 0], atol=0.012)


def test_several_files() -> None:
    paths = [FOLDER / f"phyphox_{name}.csv" for name in ("Accelerometer", "Gyroscope")]
    found = read_written(paths, pen()).recording  # type: ignore[arg-type]
    for sensor, path in zip(("accel", "gyro"), paths, strict=True):
        table = pd.read_csv(path).to_numpy()
        times, values = found.sensor(sensor)
        np.testing.assert_allclose(times, table[:, 0], rtol=0, atol=1e-9)
        np.testing.assert_array_equal(values, table[:, 1:])


def test_milliseconds_under_seconds() -> None:
    path = FOLDER / "time_ms_under_time_s.csv"
    with pytest.raises(InputError, match=r"looks like ms .* expected --units time=ms"):
        read_written(path, pen())  # type: ignore[arg-type]
    found = read_written(path, pen(), units={"time": "ms"}).recording  # type: ignore[arg-type]
    np.testing.assert_allclose(np.diff(found.time_s), 0.01, atol=1e-9)


def test_angles_are_no_recording() -> None:
    with pytest.raises(InputError, match="no sensor's columns among time_s, azimuth_deg"):
        read_written(FOLDER / "truth.csv", pen())  # type: ignore[arg-type]


def test_user_acceleration_loads() -> None:
    found = read_written(FOLDER / "user_acceleration_canonical.csv", pen()).recording  # type: ignore[arg-type]
    assert float(np.median(np.linalg.norm(found.readings["accel"], axis=1))) < G / 2
