"""A reading at its sensor's range limit says nothing: it counts as missing, with a remark."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf, EkfConfig
from estimation.estimate import Estimate
from estimation.estimator import Estimator
from estimation.kalman_stage import rows_present
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig, MheIpoptConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from mhe.reference.ipopt import MheIpopt
from models.pen import pen_model
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_model import SATURATED_FRACTION
from models.state_space import StateSpaceModel
from tests.estimation import pens
from tests.models.pens import ACCELEROMETER, CAMERA, GYROSCOPE, pen

pytestmark = pytest.mark.usefixtures("interpreted")

ACCEL_RANGE, GYRO_RANGE, GYRO_STEP = 40.0, 9.0, 0.05
RUN = pens.draw_pen_run(8, seed=11)
AT = 3
"""The instant of the reading in question: inside the window, with three steps after it."""

ESTIMATORS: dict[str, Callable[[StateSpaceModel], Estimator[Any]]] = {
    "ekf": Ekf,
    "mhe-ipopt": lambda model: MheIpopt(model, MheIpoptConfig(horizon=3)),
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=3)),
    "mhe": lambda model: Mhe(model, MheConfig(horizon=3)),
}
FIRST_AXIS = {"accel": 0, "gyro": 3}


def ranged(model: StateSpaceModel) -> StateSpaceModel:
    """The model of the run with ranges: of the accelerometer, and of a coarse gyroscope."""
    accel, gyro, camera = model.sensors
    accel = replace(accel, reading_limit=ACCEL_RANGE)
    gyro = replace(gyro, reading_limit=GYRO_RANGE, resolution=GYRO_STEP)
    return model.replace(sensors=(accel, gyro, camera))


MODEL = ranged(RUN.model)
LIMIT = {"accel": SATURATED_FRACTION * ACCEL_RANGE, "gyro": GYRO_RANGE - GYRO_STEP}
"""|y| from which a reading counts as saturated."""


@cache
def built(name: str) -> Estimator[Any]:
    """Return an estimator of the ranged model: a step changes none."""
    return ESTIMATORS[name](MODEL)


def with_reading(value: float, row: int) -> list[Measurement]:
    """The run, all of it within ranges, with one reading set."""
    measurements = []
    for k, measurement in enumerate(RUN.measurements):
        y = np.where(np.abs(measurement.y) < 0.9 * MODEL.saturation, measurement.y, np.nan)
        if k == AT:
            y[:6] = np.where(np.isnan(y[:6]), 0.1, y[:6])
            y[row] = value
        measurements.append(Measurement(measurement.time_s, y))
    return measurements


def estimates(estimator: Estimator[Any], measurements: Sequence[Measurement]) -> list[Estimate]:
    state, found = estimator.init(), []
    for measurement in measurements:
        state, estimate = estimator.step(state, measurement)
        found.append(estimate)
    return found


def assert_equal(one: Estimate, other: Estimate) -> None:
    """To the last bit."""
    np.testing.assert_array_equal(one.state.mean, other.state.mean)
    np.testing.assert_array_equal(one.state.covariance, other.state.covariance)
    np.testing.assert_array_equal(one.innovation, other.innovation)
    np.testing.assert_array_equal(one.innovation_covariance, other.innovation_covariance)
    if one.window is not None and other.window is not None:
        np.testing.assert_array_equal(one.window.states, other.window.states)


@pytest.mark.cover
@pytest.mark.parametrize("name", ESTIMATORS)
@pytest.mark.parametrize("sensor", LIMIT)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("beyond", [1.0, 1.2])
def test_a_reading_at_the_limit_is_a_missing_one(
    name: str, sensor: str, sign: int, beyond: float
) -> None:
    row, estimator = FIRST_AXIS[sensor] + 1, built(name)
    at_limit = estimates(estimator, with_reading(sign * beyond * LIMIT[sensor], row))
    missing = estimates(estimator, with_reading(np.nan, row))
    for k, (one, other) in enumerate(zip(at_limit, missing, strict=True)):
        assert_equal(one, other)
        assert (Status.SATURATED in one.status) is (k == AT)
        assert one.status & ~Status.SATURATED is other.status
        assert one.status.is_solved
    assert at_limit[AT].status is Status.SATURATED
    others = np.delete(np.arange(6), row)
    assert np.isnan(at_limit[AT].innovation[row])
    assert np.isfinite(at_limit[AT].innovation[others]).all()


@pytest.mark.cover
@pytest.mark.parametrize("name", ESTIMATORS)
@pytest.mark.parametrize("sensor", LIMIT)
def test_just_below_the_limit_it_is_used(name: str, sensor: str) -> None:
    row, estimator = FIRST_AXIS[sensor], built(name)
    below = estimates(estimator, with_reading(np.nextafter(LIMIT[sensor], 0), row))
    missing = estimates(estimator, with_reading(np.nan, row))
    assert not below[AT].status & ~Status.IMPROBABLE
    assert np.isfinite(below[AT].innovation[row])
    moved = (below[AT].state.mean - missing[AT].state.mean) / missing[AT].state.std
    assert np.abs(moved).max() > 1.0  # far off, and believed


@pytest.mark.parametrize("name", ESTIMATORS)
def test_other_axes_of_the_sensor_are_used(name: str) -> None:
    estimator = built(name)
    measurements = with_reading(LIMIT["accel"], 0)
    without = list(measurements)
    y = measurements[AT].y.copy()
    y[:3] = np.nan
    without[AT] = Measurement(measurements[AT].time_s, y)
    one = estimates(estimator, measurements)[AT].state
    other = estimates(estimator, without)[AT].state
    assert one.std[10:13].min() < 0.9 * other.std[10:13].min()


@pytest.mark.parametrize("name", ESTIMATORS)
def test_all_readings_saturated_are_no_reading(name: str) -> None:
    estimator = built(name)
    y = np.full(MODEL.n_y, np.nan)
    y[:3] = ACCEL_RANGE
    _, estimate = estimator.step(estimator.init(), Measurement(0.0, y))
    assert estimate.status is Status.SATURATED | Status.NO_READING
    assert estimate.status.is_solved
    error = np.abs(estimate.state.mean - MODEL.prior.mean) / MODEL.prior.std
    assert error.max() < 1e-9


@pytest.mark.parametrize("name", ESTIMATORS)
def test_an_infinite_reading_is_not_called_saturated(name: str) -> None:
    estimator = built(name)
    infinite = estimates(estimator, with_reading(-np.inf, 1))
    missing = estimates(estimator, with_reading(np.nan, 1))
    assert infinite[AT].status is Status.INFINITE_READING
    for one, other in zip(infinite, missing, strict=True):
        assert_equal(one, other)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_sensors_without_a_range_never_saturate(name: str) -> None:
    assert np.isinf(RUN.model.saturation).all()
    estimator = ESTIMATORS[name](RUN.model)
    found = estimates(estimator, with_reading(1e4, 2)[: AT + 2])
    assert not any(Status.SATURATED in estimate.status for estimate in found)
    assert np.isfinite(found[AT].innovation[2])


def test_a_saturated_reading_is_not_gated() -> None:
    """It is no outlier: it is not compared with its prediction at all."""
    ekf = Ekf(MODEL, EkfConfig(gate_probability=0.999))
    assert estimates(ekf, with_reading(LIMIT["accel"], 0))[AT].status is Status.SATURATED
    below = estimates(ekf, with_reading(0.99 * LIMIT["accel"], 0))[AT]
    assert Status.GATED in below.status
    assert Status.SATURATED not in below.status


@pytest.mark.parametrize(
    ("resolution", "limit"),
    [(0.0, 0.999 * 20.0), (0.001, 0.999 * 20.0), (0.02, 19.98), (0.5, 19.5)],
)
def test_the_limit_lies_a_code_or_a_thousandth_inside_the_range(
    resolution: float, limit: float
) -> None:
    accel = Accelerometer(**ACCELEROMETER, range_m_s2=20.0, resolution_m_s2=resolution)
    sensor = pen_model(pen(6, {"it": accel})).sensor("it")
    assert sensor.saturation_limit == pytest.approx(limit, rel=1e-12)


@pytest.mark.parametrize("bits", [8, 10, 12, 16])
def test_the_largest_code_of_a_converter_is_saturated(bits: int) -> None:
    """Two's complement: codes from -2^(n-1) to 2^(n-1) - 1, of a step range / 2^(n-1)."""
    codes, full_scale = 2 ** (bits - 1), 5.0
    step = full_scale / codes
    gyro = Gyroscope(**GYROSCOPE, range_rad_s=full_scale, resolution_rad_s=step)
    model = pen_model(pen(6, {"it": gyro}), writing_area=False)
    for code, present in ((codes - 1, False), (-codes, False), (0, True)):
        y = np.array([code * step, 0.0, np.nan])
        np.testing.assert_array_equal(rows_present(model, y), [present, True, False])
    # A fine converter has several codes in the last thousandth of its range.
    below = min(codes - 2, int(0.9989 * codes)) * step
    assert rows_present(model, np.array([below, -below, 0.0])).all()


def test_every_reading_has_the_limit_of_its_sensor() -> None:
    sensors = {
        "accel": Accelerometer(**ACCELEROMETER, range_m_s2=40.0, axes=("x", "z")),
        "camera": PoseCamera(**CAMERA),
        "gyro": Gyroscope(**GYROSCOPE, range_rad_s=9.0),
    }
    model = pen_model(pen(6, sensors))
    expected = [0.999 * 40.0] * 2 + [np.inf] * 6 + [0.999 * 9.0] * 3
    assert model.saturation == pytest.approx(expected, rel=1e-12)
    y = np.array([0.0, 1e9, 1e9, 0, 0, 0, 0, 0, -8.9, 9.0, 0.0], dtype=float)
    present = rows_present(model, y)
    np.testing.assert_array_equal(present, [1, 0, 1, 1, 1, 1, 1, 1, 1, 0, 1])
