"""Every pen whose position nothing else sees gets a writing area, unless it is told not to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from models.pen import pen_model
from models.pen_config import PenConfig, Prior
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.contact import Contact
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_kinds.writing_area import WritingArea
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from tests.models.pens import ACCELEROMETER, CAMERA, GYROSCOPE, pen

TIP = (0.1, -0.2, 0.05)
PLAIN: dict[str, Any] = {
    "accel": Accelerometer(**ACCELEROMETER),
    "gyro": Gyroscope(**GYROSCOPE),
    "camera": PoseCamera(**CAMERA),
    "contact": Contact(std_m=5e-4),
}
"""A pen file without an area of its own."""

WITHOUT_CAMERA = [
    ["accel"],
    ["gyro"],
    ["contact"],
    ["accel", "gyro"],
    ["gyro", "accel", "contact"],
]


def config(sensors: dict[str, Any], degrees_of_freedom: int = 6) -> PenConfig:
    return pen(degrees_of_freedom, sensors, prior=Prior(tip_m=TIP))


def names(model: StateSpaceModel) -> list[str]:
    return [sensor.name for sensor in model.sensors]


def area_of(model: StateSpaceModel) -> SensorModel:
    (area,) = (sensor for sensor in model.sensors if sensor.kind == "writing_area")
    return area


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("sensors", WITHOUT_CAMERA, ids="+".join)
def test_without_a_camera_an_area_is_added_last(
    degrees_of_freedom: int, sensors: list[str]
) -> None:
    """A contact holds the height only: it does not count as seeing the position."""
    model = pen_model(config(PLAIN, degrees_of_freedom), sensors)
    assert names(model) == [*sensors, "area"]
    area = area_of(model)
    assert area.constant_reading == pytest.approx(TIP, abs=0)
    assert area.noise_std == pytest.approx([1.0] * 3, abs=0)
    assert area.rate_hz == 100.0
    assert area not in model.measured_sensors


@pytest.mark.parametrize(
    "sensors", [["camera"], ["accel", "camera"], ["gyro", "camera", "contact"]]
)
def test_with_a_camera_there_is_none(sensors: list[str]) -> None:
    assert names(pen_model(config(PLAIN), sensors)) == sensors
    with_own = {**PLAIN, "desk": WritingArea()}
    assert names(pen_model(config(with_own), sensors)) == sensors


@pytest.mark.parametrize("sensors", WITHOUT_CAMERA, ids="+".join)
def test_it_can_be_refused(sensors: list[str]) -> None:
    assert names(pen_model(config(PLAIN), sensors, writing_area=False)) == sensors
    with_own = {**PLAIN, "desk": WritingArea()}
    assert names(pen_model(config(with_own), sensors, writing_area=False)) == sensors


def test_refusing_the_addition_keeps_an_area_that_was_asked_for() -> None:
    with_own = {**PLAIN, "desk": WritingArea(std_m=0.4)}
    model = pen_model(config(with_own), ["gyro", "desk"], writing_area=False)
    assert names(model) == ["gyro", "desk"]


@pytest.mark.parametrize("sensors", WITHOUT_CAMERA, ids="+".join)
def test_the_pen_files_own_area_is_taken(sensors: list[str]) -> None:
    own = WritingArea(centre_m=(0.3, 0.4, 0.0), std_m=0.25, rate_hz=20.0)
    model = pen_model(config({**PLAIN, "desk": own}), sensors)
    assert names(model) == [*sensors, "desk"]
    area = area_of(model)
    assert area.constant_reading == pytest.approx([0.3, 0.4, 0.0], abs=0)
    assert area.noise_std == pytest.approx([0.25] * 3, abs=0)
    assert area.rate_hz == 20.0


def test_an_area_among_the_sensors_keeps_its_place() -> None:
    with_own = {**PLAIN, "desk": WritingArea(std_m=0.4)}
    model = pen_model(config(with_own), ["desk", "gyro"])
    assert names(model) == ["desk", "gyro"]
    assert names(pen_model(config(with_own), ["desk", "camera"])) == ["desk", "camera"]


def test_a_sensor_called_area_keeps_its_name() -> None:
    sensors = {"area": PLAIN["accel"], "gyro": PLAIN["gyro"]}
    assert names(pen_model(config(sensors), ["area"])) == ["area", "writing_area"]
    assert names(pen_model(config(sensors), ["gyro"])) == ["gyro", "writing_area"]
    assert area_of(pen_model(config(sensors), ["area"])).name == "writing_area"


def test_all_sensors_of_a_pen_file() -> None:
    inertial = {name: PLAIN[name] for name in ("accel", "gyro")}
    assert names(pen_model(config(inertial))) == ["accel", "gyro", "area"]
    assert names(pen_model(config(PLAIN))) == list(PLAIN)


def test_the_area_reads_the_tip_and_nothing_else() -> None:
    area = area_of(pen_model(config(PLAIN), ["gyro"]))
    x = np.arange(1.0, 19.0)
    np.testing.assert_array_equal(np.asarray(area.h(x)).ravel(), x[:3])
    slope = np.asarray(area.h.jacobian()(x, 0).full())
    np.testing.assert_array_equal(slope, np.eye(3, 18))
