"""Arrivals of readings: what a recording holds, what becomes of them, and the order they make."""

from __future__ import annotations

import dataclasses
from typing import Any

import casadi as ca
import numpy as np
import pytest

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.own_models import OwnSensor, own_model
from models.state_space import StateSpaceModel
from tests.estimation.test_measurements import CENTRE, model_with_area

NAN = np.nan
TIMES = np.array([0.0, 0.01, 0.015, 0.02, 0.03])
ENCODER = np.array([0.0, 1.0, NAN, 2.0, 3.0])
CAMERA = np.array([NAN, NAN, 5.0, NAN, 6.0])
ARRIVALS = np.array([NAN, NAN, 0.025, NAN, 0.03])
LATE = 3
"""Row of the first frame where readings stand as they arrive."""


def recording(**changes: Any) -> Recording:
    """An encoder on time, a camera whose second frame arrives at its capture."""
    given: dict[str, Any] = {
        "readings": {"encoder": ENCODER, "camera": CAMERA},
        "arrivals": {"camera": ARRIVALS},
    }
    return Recording("r", TIMES, **{**given, **changes})


def model(*, delay_s: float = 0.0, inputs: tuple[str, ...] = ()) -> StateSpaceModel:
    """A walk that an encoder and a camera read, the camera late."""

    def transition(x: ca.SX, w: ca.SX, dt: ca.SX, *u: ca.SX) -> ca.SX:
        return x + ca.sqrt(dt) * w + sum((dt * each[0] for each in u), ca.SX(0))

    sensor = OwnSensor(lambda x: x[0], axes={"x": "m"}, noise_std=0.1)
    built = own_model(
        "walk",
        {"position_m": (0.0, 1.0)},
        transition,
        1,
        {"encoder": sensor, "camera": sensor},
        inputs=inputs,
    )
    encoder, camera = built.sensors
    return built.replace(sensors=(encoder, dataclasses.replace(camera, delay_s=delay_s)))


def test_rows_stand_in_the_order_of_arrival() -> None:
    time_s, y, arrival_s = recording().as_arrived(model())
    np.testing.assert_array_equal(time_s, [0.0, 0.01, 0.02, 0.015, 0.03])
    np.testing.assert_array_equal(arrival_s, [0.0, 0.01, 0.02, 0.025, 0.03])
    np.testing.assert_array_equal(y[:, 0], [0.0, 1.0, 2.0, NAN, 3.0])
    np.testing.assert_array_equal(y[:, 1], [NAN, NAN, NAN, 5.0, 6.0])
    measured = list(recording().measurements(model(), causal=True))
    np.testing.assert_array_equal([m.time_s for m in measured], time_s)
    np.testing.assert_array_equal([m.arrival_s for m in measured], arrival_s)
    np.testing.assert_array_equal([m.y for m in measured], y)


def test_of_one_arrival_the_older_capture_comes_first() -> None:
    arrivals = np.array([NAN, NAN, 0.03, NAN, 0.03])
    time_s, y, arrival_s = recording(arrivals={"camera": arrivals}).as_arrived(model())
    np.testing.assert_array_equal(time_s[3:], [0.015, 0.03])
    np.testing.assert_array_equal(arrival_s[3:], [0.03, 0.03])
    np.testing.assert_array_equal(y[3:], [[NAN, 5.0], [3.0, 6.0]])


def test_without_arrivals_a_reading_is_late_by_its_sensors_delay() -> None:
    time_s, _, arrival_s = recording(arrivals={}).as_arrived(model(delay_s=0.012))
    np.testing.assert_array_equal(arrival_s, [0.0, 0.01, 0.02, 0.027, 0.03, 0.042])
    np.testing.assert_array_equal(time_s, [0.0, 0.01, 0.02, 0.015, 0.03, 0.03])
    known = recording().as_arrived(model(delay_s=0.012))[2]
    np.testing.assert_array_equal(known, recording().as_arrived(model())[2])


def test_without_delays_it_is_the_order_of_capture() -> None:
    time_s, y, arrival_s = recording(arrivals={}).as_arrived(model())
    in_order = recording().stacked(model())
    np.testing.assert_array_equal(time_s, in_order[0])
    np.testing.assert_array_equal(arrival_s, in_order[0])
    np.testing.assert_array_equal(y, in_order[1])


def test_an_instant_at_which_nothing_arrives_has_no_row() -> None:
    """Else it would tell beforehand that something was captured there."""
    lost = recording(readings={"encoder": ENCODER, "camera": np.full(5, NAN)})
    np.testing.assert_array_equal(lost.as_arrived(model())[0], [0.0, 0.01, 0.02, 0.03])
    assert len(lost.stacked(model())[0]) == 5
    empty = recording(readings={"encoder": np.full(5, NAN), "camera": np.full(5, NAN)})
    with pytest.raises(InputError, match=r"no sensor of walk has a reading, expected one that"):
        empty.as_arrived(model())


def test_inputs_arrive_at_their_instant_and_not_with_what_is_late() -> None:
    force = np.array([1.0, NAN, 2.0, NAN, 3.0])
    given = recording(inputs={"force": force})
    time_s, y, arrival_s = given.as_arrived(model(inputs=("force",)))
    np.testing.assert_array_equal(time_s, [0.0, 0.01, 0.015, 0.02, 0.015, 0.03])
    np.testing.assert_array_equal(arrival_s, [0.0, 0.01, 0.015, 0.02, 0.025, 0.03])
    np.testing.assert_array_equal(y[:, 2], [1.0, 1.0, 2.0, 2.0, NAN, 3.0])
    assert np.isnan(y[2, :2]).all()


def test_constant_readings_go_with_what_is_on_time() -> None:
    """An area of 100 Hz: the first of each 10 ms among rows newer than all before."""
    times = np.array([0.0, 0.004, 0.008, 0.012, 0.016, 0.02])
    accel = np.tile(np.arange(6.0)[:, None], 3)
    arrivals = times + np.array([0.0, 0.0, 0.006, 0.0, 0.0, 0.0])
    given = Recording("r", times, {"accel": accel}, arrivals={"accel": arrivals})
    time_s, y, _ = given.as_arrived(model_with_area(100.0))
    np.testing.assert_array_equal(time_s, [0.0, 0.004, 0.012, 0.008, 0.016, 0.02])
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(y[:, 3])), [0, 2, 5])
    np.testing.assert_array_equal(y[2, 3:], CENTRE)


def test_periods_do_not_depend_on_later_instants() -> None:
    """Rounding is by each instant: a late year in the same recording moves no period."""
    sensor = model_with_area(30.0).sensors[1]
    times = np.arange(600) / 30.0
    alone = sensor.first_of_each_period(times)
    np.testing.assert_array_equal(sensor.first_of_each_period(np.append(times, 1e9))[:-1], alone)


def arrivals_of(given: Recording, sensor: str = "camera") -> Array:
    times = given.sensor(sensor)[0]
    return given.arrivals[sensor][np.isin(given.time_s, times)]


def test_arrivals_stay_with_their_readings() -> None:
    np.testing.assert_array_equal(arrivals_of(recording().select(["camera"])), [0.025, 0.03])
    assert not recording().select(["encoder"]).arrivals
    np.testing.assert_array_equal(arrivals_of(recording().subsampled("camera", 2, 1)), [0.03])
    np.testing.assert_array_equal(arrivals_of(recording().first(0.02)), [0.025])
    merged = Recording.from_sensors(
        "r",
        {"encoder": (TIMES[:2], [1.0, 2.0]), "camera": ([0.005], [5.0])},
        arrivals={"camera": np.array([0.02])},
    )
    np.testing.assert_array_equal(merged.arrivals["camera"], [NAN, 0.02, NAN])


def test_an_arrival_of_no_reading_is_none_and_rounding_is_forgiven() -> None:
    arrivals = np.array([0.0, 0.01, 0.025, 0.02, 0.03 - 1e-10])
    kept = recording(arrivals={"camera": arrivals}).arrivals["camera"]
    np.testing.assert_array_equal(kept, ARRIVALS)


BAD = {
    "kind": ([0.1], "arrivals are a list, expected sensor name → "),
    "sensor": ({"lamp": ARRIVALS}, "arrivals of lamp, which has no readings; expected one of enc"),
    "shape": ({"camera": ARRIVALS[:3]}, r"arrivals of camera have shape \(3,\), expected \(5,\)"),
    "missing": ({"camera": TIMES * NAN}, "of camera at 0.015 s arrives at nan s, expected a time"),
    "early": (
        {"camera": TIMES - 0.001},
        "camera at 0.015 s arrives at 0.014 s, expected a time",
    ),
    "infinite": ({"camera": TIMES + np.inf}, "of camera at 0.015 s arrives at inf s"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_arrivals_are_refused(case: str) -> None:
    arrivals, sentence = BAD[case]
    with pytest.raises(InputError, match=sentence):
        recording(arrivals=arrivals)


@pytest.mark.parametrize(
    ("arrivals", "sentence"),
    [
        ({"lamp": [0.1]}, "arrivals of lamp, which has no readings; expected one of camera"),
        ({"camera": [0.1]}, r"arrivals of camera have shape \(1,\), expected \(2,\)"),
    ],
)
def test_arrivals_of_sensors_are_one_each(arrivals: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        Recording.from_sensors("r", {"camera": (TIMES[:2], CAMERA[:2])}, arrivals=arrivals)
