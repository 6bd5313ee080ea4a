"""A bad pen file, option, unit or D-POINT folder gets one sentence: where, and what else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from models.units import STANDARD_GRAVITY_M_S2
from recordings.formats.dpoint import CAMERA_FILE, STYLUS_FILE
from tests.pen_mhe.bad_input import (
    ACCEL,
    GYRO,
    Case,
    check_sentence,
    dpoint,
    estimate,
    in_other_unit,
)

pytestmark = pytest.mark.usefixtures("interpreted")
DEG = np.pi / 180
ACCELERATION = "[sensors.accel]\n"
TOO_TINY_STD = 1e-170
"""Its square is zero, so the covariance is singular."""


def put(rows: list[Any], row: int, key: str, value: Any) -> None:
    (rows[row] if key == "t" else rows[row]["data"])[key.removeprefix("data.")] = value


UNITS = {
    "accelerometer in g": Case(
        ("pen.csv: accel was read in m_s2 but looks like g", "the median of its norm is ",
         "gravity 9.81 m/s2", "expected --units accel=g or headers like accel_x_g"),
        in_other_unit(ACCEL, 1 / STANDARD_GRAVITY_M_S2),
    ),
    "accelerometer in m/s2 under g": Case(
        ("pen.csv: accel was read in g but looks like m_s2", "expected --units accel=m_s2"),
        in_other_unit(ACCEL, 1.0, "m_s2", "g"),
    ),
    "accelerometer in mg": Case(
        ("pen.csv: accel was read in m_s2 but looks like mg", "expected --units accel=mg"),
        in_other_unit(ACCEL, 1000 / STANDARD_GRAVITY_M_S2),
    ),
    "accelerometer in m/s2, called g": Case(
        ("pen.csv: accel was read in g but looks like m_s2", "expected --units accel=m_s2"),
        in_other_unit(ACCEL, 1.0, "_m_s2", ""),
        options=("--units", "accel=g"),
    ),
    "gyroscope in deg/s": Case(
        ("pen.csv: gyro was read in rad_s but looks like deg_s", "gravity turns in accel",
         "expected --units gyro=deg_s or headers like gyro_x_deg_s"),
        in_other_unit(GYRO, 1 / DEG),
    ),
    "gyroscope in rad/s under deg/s": Case(
        ("pen.csv: gyro was read in deg_s but looks like rad_s", "gravity turns in accel",
         "expected --units gyro=rad_s or headers like gyro_x_rad_s"),
        in_other_unit(GYRO, 1.0, "rad_s", "deg_s"),
    ),
    "unknown unit": Case(
        ("pen.csv: unit furlong of accel is unknown", "expected m_s2 or g or mg"),
        in_other_unit(ACCEL, 1.0, "_m_s2", ""),
        options=("--units", "accel=furlong"),
    ),
    "unit given beside a header's": Case(
        ("pen.csv: a unit is given for accel", "expected columns of it without a unit"),
        options=("--units", "accel=g"),
    ),
    "unit given for a D-POINT folder": Case(
        ("units are given for a D-POINT folder", "expected none"),
        dpoint(), pen="dpoint", options=("--units", "accel=g"),
    ),
}  # fmt: skip

PEN = {
    "missing pen": Case(
        ("pen file none.toml does not exist", "expected a file, or a bundled pen: compass"),
        options=("--pen", "none.toml"),
    ),
    "not TOML": Case(("my.toml: ", "expected TOML"), replace=(ACCELERATION, "[sensors.accel\n")),
    "unknown key": Case(
        ("my.toml: key sensors.accel: unknown key nose_density", "expected one of axes, bandw"),
        replace=(ACCELERATION, ACCELERATION + "nose_density = 1\n"),
    ),
    "unknown unit": Case(
        ("my.toml: key sensors.accel: unknown key range_furlong", "expected range_m_s2 or range_g"),
        replace=("range_g = 4.0", "range_furlong = 4.0"),
    ),
    "unknown sensor kind": Case(
        ("my.toml: key sensors.camera", "radar", "expected", "accelerometer"),
        replace=('kind = "pose_camera"', 'kind = "radar"'),
    ),
    "unknown preset": Case(
        ("my.toml: key sensors.accel.preset: unknown preset BMI", "expected one of ADXL202"),
        replace=("LSM6DS3-accelerometer", "BMI"),
    ),
    "scaled matrix": Case(
        ("my.toml: key sensors.accel.sensor_to_body: expected a rotation matrix", "orthonormal"),
        replace=(ACCELERATION, ACCELERATION + "sensor_to_body = [[2,0,0],[0,1,0],[0,0,1]]\n"),
    ),
    "reflection": Case(
        ("my.toml: key sensors.accel.sensor_to_body: expected a rotation matrix", "determinant"),
        replace=(ACCELERATION, ACCELERATION + "sensor_to_body = [[1,0,0],[0,1,0],[0,0,-1]]\n"),
    ),
    "standard deviation of zero": Case(
        ("my.toml: key prior.tip_std_m: ", "should be greater than 0"),
        replace=("tip_std_m = 0.1", "tip_std_m = 0.0"),
    ),
    "singular covariance": Case(
        ("model reference pen", "prior covariance is not positive definite"),
        replace=("tip_std_m = 0.1", f"tip_std_m = {TOO_TINY_STD}"),
    ),
    "bias walk without a bias": Case(
        ("my.toml: key sensors.accel: bias_walk_m_s2_per_sqrt_s is given without bias_std_m_s2",
         "expected a positive bias_std_m_s2"),
        replace=("bias_std_mg = 20.0", ""),
    ),
    "bounds that leave nothing": Case(
        ("model reference pen", "bound on tip_z_m: lower 0.1 is not below upper 0.0",
         "expected lower < upper"),
        replace=("[prior]", "[bounds]\ntip_z_m = [0.1, 0.0]\n[prior]"),
    ),
    "bound on no state": Case(
        ("model reference pen", "bound on unknown state tip_z_mm", "expected one of tip_x_m"),
        replace=("[prior]", "[bounds]\ntip_z_mm = [0.0, 0.1]\n[prior]"),
    ),
}  # fmt: skip

OPTIONS = {
    "unknown sensor": Case(
        ("sensor radar is not in the pen reference pen", "expected one of accel, gyro"),
        options=("--sensors", "accel,radar"),
    ),
    "sensor without readings": Case(
        ("pen.csv has no sensor camera", "expected one of accel, gyro"),
        options=("--sensors", "accel,camera"),
    ),
    "horizon of zero": Case(
        ("horizon is 0", "expected a whole number of at least 1"),
        options=("--estimator", "mhe", "--horizon", "0"),
    ),
}

DPOINT = {
    "not D-POINT": Case(
        ("is a folder without D-POINT's files", f"expected {STYLUS_FILE} and {CAMERA_FILE}"),
        lambda folder: folder,
        pen="dpoint",
    ),
    "repeated time": Case(
        (f"{STYLUS_FILE}: row 3: data.t (108 ms) does not follow the one before (108 ms)",
         "expected increasing times"),
        dpoint(lambda stylus, camera: put(stylus, 2, "data.t", 108)),
        pen="dpoint",
    ),
    "backward frame": Case(
        (f"{CAMERA_FILE}: row 2: t (149 ms) does not follow the one before (150 ms)",
         "expected increasing times"),
        dpoint(lambda stylus, camera: put(camera, 1, "t", 149)),
        pen="dpoint",
    ),
    "NaN": Case(
        (f"{STYLUS_FILE}: row 2: data.gyro is not finite", "expected (3,)"),
        dpoint(lambda stylus, camera: put(stylus, 1, "data.gyro", [0, np.nan, 0])),
        pen="dpoint",
    ),
    "missing key": Case(
        (f"{STYLUS_FILE}: row 1 has no number under data.accel",),
        dpoint(lambda stylus, camera: stylus[0]["data"].pop("accel")),
        pen="dpoint",
    ),
    "no samples": Case(
        (f"{STYLUS_FILE}: expected a list of samples, got none",),
        dpoint(lambda stylus, camera: stylus.clear()),
        pen="dpoint",
    ),
    "scaled matrix": Case(
        (f"{CAMERA_FILE}: row 2: data.orientation_mat, expected a rotation",),
        dpoint(lambda stylus, camera: put(
            camera, 1, "data.orientation_mat", [[2, 0, 0], [0, 1, 0], [0, 0, 1]])),
        pen="dpoint",
    ),
    "reflection": Case(
        (f"{CAMERA_FILE}: row 1: data.orientation_mat, expected a rotation",),
        dpoint(lambda stylus, camera: put(
            camera, 0, "data.orientation_mat", [[1, 0, 0], [0, 1, 0], [0, 0, -1]])),
        pen="dpoint",
    ),
}  # fmt: skip

CASES = {
    f"{group}: {name}": case
    for group, cases in (
        ("units", UNITS),
        ("pen", PEN),
        ("options", OPTIONS),
        ("D-POINT", DPOINT),
    )
    for name, case in cases.items()
}


@pytest.mark.parametrize("name", CASES)
def test_one_sentence_for_a_bad_setting(name: str, tmp_path: Path) -> None:
    check_sentence(CASES[name], tmp_path)


def test_the_folder_of_the_cases_is_good(tmp_path: Path) -> None:
    options = ("--sensors", "accel,gyro,camera")
    result = estimate(Case((), dpoint(), pen="dpoint", options=options), tmp_path)
    assert result.exit_code == 0, result.stderr
