"""Errors in the units people read: a free pen's angles and rates of its body."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ekf_baseline.ekf import Ekf
from estimation.estimate import EstimateHistory
from estimation.estimator import run
from estimation.recording import Recording, Truth
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from pen_mhe.errors import (
    ERROR_COLUMNS,
    NOT_OBSERVABLE,
    rms_errors,
    root_mean_square,
    seen_only,
    state_errors,
)
from pen_mhe.sensor_verdict import judge
from recordings.simulate_pen import simulate

pytestmark = pytest.mark.usefixtures("interpreted")

SENSORS = ("accel", "gyro")


@cache
def model(degrees_of_freedom: int) -> StateSpaceModel:
    config = load_pen("reference").model_copy(update={"degrees_of_freedom": degrees_of_freedom})
    return pen_model(config, SENSORS)


@cache
def recording(degrees_of_freedom: int) -> Recording:
    config = load_pen("reference").model_copy(update={"degrees_of_freedom": degrees_of_freedom})
    return simulate(config, SENSORS, motion="handwriting", duration_s=0.5, seed=4)


@cache
def history(degrees_of_freedom: int) -> EstimateHistory:
    return run(Ekf(model(degrees_of_freedom)), recording(degrees_of_freedom))


def truth_of(degrees_of_freedom: int) -> Truth:
    truth = recording(degrees_of_freedom).truth
    assert truth is not None
    return truth


def test_a_free_pens_errors_are_those_of_angles_and_of_its_bodys_rates() -> None:
    """By SciPy from the states; the truth's own attitude is its quaternion."""
    found, truth = history(6), truth_of(6)
    rms = rms_errors(model(6), found, truth)
    assert list(rms) == ["tip_mm", "azimuth_deg", "elevation_deg", "spin_deg", "rates_deg_s"]
    true = dict(zip(truth.names, truth.values.T, strict=True))
    quaternion = np.column_stack([true[f"attitude_{axis}"] for axis in "wxyz"])
    attitudes = (
        Rotation.from_mrp(found.mean[:, 3:6]),
        Rotation.from_quat(quaternion, scalar_first=True),
    )
    away = np.subtract(*(attitude.as_euler("ZYZ") for attitude in attitudes))
    away = np.angle(np.exp(1j * away))
    for column, error in zip(("azimuth_deg", "elevation_deg", "spin_deg"), away.T, strict=True):
        assert rms[column] == pytest.approx(np.degrees(np.sqrt(np.mean(error**2))), rel=1e-9)
    rates = np.column_stack([true[f"body_rate_{axis}_rad_s"] for axis in "xyz"])
    squared = ((found.mean[:, 9:12] - rates) ** 2).sum(axis=1)
    assert rms["rates_deg_s"] == pytest.approx(np.degrees(np.sqrt(squared.mean())), rel=1e-12)


def test_a_pen_without_spin_has_the_rates_of_its_angles() -> None:
    found, truth = history(5), truth_of(5)
    rms = rms_errors(model(5), found, truth)
    assert list(rms) == ["tip_mm", "azimuth_deg", "elevation_deg", "rates_deg_s"]
    true = dict(zip(truth.names, truth.values.T, strict=True))
    names = ("azimuth_rate_rad_s", "elevation_rate_rad_s")
    squared = sum((found.column(name) - true[name]) ** 2 for name in names)
    assert rms["rates_deg_s"] == pytest.approx(np.degrees(np.sqrt(np.mean(squared))), rel=1e-12)


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_errors_have_a_column_for_each_name(degrees_of_freedom: int) -> None:
    found = history(degrees_of_freedom)
    errors = state_errors(model(degrees_of_freedom), found, truth_of(degrees_of_freedom))
    assert errors.shape == (len(found), len(found.names))
    assert np.isfinite(errors).all()


def test_a_truth_of_angles_alone_has_their_errors_alone() -> None:
    truth = truth_of(6)
    index = [truth.names.index(name) for name in ("azimuth_rad", "elevation_rad")]
    part = Truth(truth.time_s, ("azimuth_rad", "elevation_rad"), truth.values[:, index])
    errors = state_errors(model(6), history(6), part)
    rms = root_mean_square(history(6).names, errors, ERROR_COLUMNS)
    assert list(rms) == ["azimuth_deg", "elevation_deg"]
    whole = rms_errors(model(6), history(6), truth)
    assert rms == {column: whole[column] for column in rms}


def test_what_no_sensor_sees_is_no_number() -> None:
    values = rms_errors(model(6), history(6), truth_of(6))
    shown = seen_only(model(6), values, judge(model(6), recording(6)))
    unseen = {column for column, value in shown.items() if value == NOT_OBSERVABLE}
    assert unseen == {"tip_mm", "azimuth_deg"}
    assert {column: values[column] for column in shown.keys() - unseen} == {
        column: shown[column] for column in shown.keys() - unseen
    }


def test_of_a_gyroscope_alone_only_rates_are_numbers() -> None:
    gyro = pen_model("reference", ["gyro"])
    data = simulate("reference", ["gyro"], motion="handwriting", duration_s=0.5)
    assert data.truth is not None
    values = rms_errors(gyro, run(Ekf(gyro), data), data.truth)
    shown = seen_only(gyro, values, judge(gyro, data))
    assert [column for column, value in shown.items() if value != NOT_OBSERVABLE] == ["rates_deg_s"]
