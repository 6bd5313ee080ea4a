"""Derived accelerometers and gyroscopes against differences of a trajectory in NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from models.pen import pen_model
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.contact import Contact
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.writing_area import WritingArea
from models.state_space import StateSpaceModel
from tests.models.pens import (
    ACCELEROMETER,
    FIXED_SPIN_RAD,
    GYROSCOPE,
    Array,
    call,
    pen,
    random_rotation,
)
from tests.references.trajectory import (
    SineMotion,
    first_difference,
    random_motion,
    second_difference,
)

RELATIVE = 1e-6
GRAVITY = 9.83
TIMES = np.linspace(0.0, 1.0, 9)
AXIS = {"x": 0, "y": 1, "z": 2}
IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


@dataclass(frozen=True, eq=False)
class Mounting:
    position_m: tuple[float, float, float]
    sensor_to_body: list[list[float]]
    axes: tuple[str, ...] = ("x", "y", "z")

    @property
    def keys(self) -> dict[str, Any]:
        return vars(self)

    def seen(self, body_vector: Array) -> Array:
        """Components along the sensor's own axes, in the order in which it has them."""
        sensor_axes = np.array(self.sensor_to_body)  # column j is sensor axis j in body axes
        return np.array([sensor_axes[:, AXIS[axis]] @ body_vector for axis in self.axes])


TURNED = random_rotation(np.random.default_rng(7))

MOUNTINGS = {
    "on the axis": Mounting((0.0, 0.0, 0.12), IDENTITY),
    "at the tip": Mounting((0.0, 0.0, 0.0), IDENTITY),
    "off the axis": Mounting((0.03, -0.05, 0.11), IDENTITY),
    "turned": Mounting((0.0, 0.0, 0.1), random_rotation(np.random.default_rng(8))),
    "turned, off the axis": Mounting((-0.02, 0.01, 0.15), TURNED),
    "two axes": Mounting((0.01, 0.02, 0.1), TURNED, ("z", "x")),
    "one axis": Mounting((0.01, 0.02, 0.1), TURNED, ("y",)),
}


def motion_of(degrees_of_freedom: int, seed: int) -> SineMotion:
    fixed_spin = FIXED_SPIN_RAD if degrees_of_freedom == 5 else None
    return random_motion(np.random.default_rng(seed), fixed_spin)


def largest_relative_error(readings: list[Array], expected: list[Array]) -> float:
    """Return the largest error over a trajectory, relative to the largest reading."""
    largest = np.abs(expected).max()
    assert largest > 0.1  # a reading that is nothing would prove nothing
    return float(np.abs(np.array(readings) - np.array(expected)).max() / largest)


@cache
def inertial_pen(degrees_of_freedom: int, mounting: Mounting, **bias: float) -> StateSpaceModel:
    accel_bias = {"bias_std_m_s2": bias["accel"]} if "accel" in bias else {}
    gyro_bias = {"bias_std_rad_s": bias["gyro"]} if "gyro" in bias else {}
    sensors = {
        "accel": Accelerometer(**ACCELEROMETER, **mounting.keys, **accel_bias),
        "gyro": Gyroscope(**GYROSCOPE, **mounting.keys, **gyro_bias),
    }
    return pen_model(pen(degrees_of_freedom, sensors, gravity_m_s2=GRAVITY))


@pytest.mark.cover
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("mounting", MOUNTINGS.values(), ids=MOUNTINGS.keys())
@pytest.mark.parametrize("seed", range(3))
def test_inertial_sensors(degrees_of_freedom: int, mounting: Mounting, seed: int) -> None:
    model = inertial_pen(degrees_of_freedom, mounting)
    motion = motion_of(degrees_of_freedom, seed)
    place = np.array(mounting.position_m)
    states = [motion.state(t, degrees_of_freedom) for t in TIMES]
    for name, expected in {
        "accel": [mounting.seen(motion.specific_force(t, place, GRAVITY)) for t in TIMES],
        "gyro": [mounting.seen(motion.body_rate(t)) for t in TIMES],
    }.items():
        readings = [call(model.sensor(name).h, x) for x in states]
        assert largest_relative_error(readings, expected) < RELATIVE, name


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("seed", range(3))
def test_motion_without_gravity(degrees_of_freedom: int, seed: int) -> None:
    """What turning adds is small beside gravity: here it has to be right on its own."""
    mounting = MOUNTINGS["turned, off the axis"]
    model, motion = inertial_pen(degrees_of_freedom, mounting), motion_of(degrees_of_freedom, seed)
    place, tip = np.array(mounting.position_m), np.zeros(3)
    readings, expected = [], []
    for t in TIMES:
        x = motion.state(t, degrees_of_freedom)
        frozen = np.concatenate([x[:degrees_of_freedom], np.zeros(2 * degrees_of_freedom)])
        frozen[2 * degrees_of_freedom :][:3] = x[2 * degrees_of_freedom :][:3]
        accel = model.sensor("accel").h
        readings.append(call(accel, x) - call(accel, frozen))
        turning = motion.specific_force(t, place, 0.0) - motion.specific_force(t, tip, 0.0)
        expected.append(mounting.seen(turning))
    assert largest_relative_error(readings, expected) < RELATIVE


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize(
    "biased", [("accel",), ("gyro",), ("accel", "gyro")], ids=lambda names: "+".join(names)
)
def test_bias_states_are_added(degrees_of_freedom: int, biased: tuple[str, ...]) -> None:
    """A bias is a state in the sensor's own axes, in the order of the sensors."""
    mounting = MOUNTINGS["two axes"]
    model = inertial_pen(degrees_of_freedom, mounting, **dict.fromkeys(biased, 0.2))
    unbiased = inertial_pen(degrees_of_freedom, mounting)
    unit = {"accel": "m_s2", "gyro": "rad_s"}
    names = tuple(f"{name}_bias_{axis}_{unit[name]}" for name in biased for axis in mounting.axes)
    assert model.state_names[3 * degrees_of_freedom :] == names
    bias = {name: np.array([0.3, -0.7]) * (1 + k) for k, name in enumerate(biased)}
    x = motion_of(degrees_of_freedom, 3).state(0.4, degrees_of_freedom)
    full = np.concatenate([x, *bias.values()])
    for name in ("accel", "gyro"):
        reading = call(unbiased.sensor(name).h, x) + bias.get(name, np.zeros(2))
        assert call(model.sensor(name).h, full) == pytest.approx(reading, rel=1e-14)


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_tip_sensors_read_the_tip(degrees_of_freedom: int) -> None:
    """Contact and writing area: reading minus tip, whatever the pen does."""
    area = WritingArea(centre_m=(0.1, 0.2, 0.03), std_m=0.3)
    sensors = {"contact": Contact(std_m=5e-4, height_m=0.02), "area": area}
    model = pen_model(pen(degrees_of_freedom, sensors))
    x = motion_of(degrees_of_freedom, 4).state(0.3, degrees_of_freedom)
    contact, desk = model.sensor("contact"), model.sensor("area")
    assert call(contact.h, x) == pytest.approx(x[2:3], abs=0)
    assert call(contact.residual, 0.02, x) == pytest.approx(0.02 - x[2:3], abs=0)
    assert contact.constant_reading is None  # it reads only while the pen presses
    assert desk.constant_reading == pytest.approx([0.1, 0.2, 0.03], abs=0)
    centre = np.array(area.centre_m)
    assert call(desk.residual, centre, x) == pytest.approx(centre - x[:3], abs=0)


def test_the_reference_differentiates_to_its_order() -> None:
    """Halving the step divides the error by 2⁴: the differences are what they claim."""
    motion = motion_of(6, 0)
    place = np.array([0.02, 0.03, 0.1])
    exact = {1: motion.derivative(0.3, 1), 2: motion.derivative(0.3, 2)}
    for order, difference in ((1, first_difference), (2, second_difference)):
        errors = [
            np.abs(difference(lambda t: motion.derivative(t, 0), 0.3, h) - exact[order]).max()
            for h in (0.02, 0.01)
        ]
        assert 12 < errors[0] / errors[1] < 20
    coarse, fine = (
        second_difference(lambda t: motion.position(t, place), 0.3, h) for h in (1e-3, 5e-4)
    )
    assert np.abs(coarse - fine).max() < RELATIVE * np.abs(fine).max()
