"""All readings of a recording at once, equal to stacking them instant by instant."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from tests.estimation.test_measurements import CENTRE, model_with_area, recording_at

SENSORS = ("gyro", "accel", "camera")


def one_by_one(recording: Recording, model: StateSpaceModel, rate_hz: float) -> Array:
    """Stack each instant on its own; the writing area speaks once per started period."""
    rows, last = [], -1
    for k, time_s in enumerate(recording.time_s):
        readings = {name: values[k] for name, values in recording.readings.items()}
        period = math.floor((time_s - recording.time_s[0] + 1e-9) * rate_hz)
        if period > last:
            readings["area"] = np.array(CENTRE)
        last = period
        rows.append(model.stack(readings))
    return np.array(rows)


@pytest.mark.parametrize("rate_hz", [100.0, 30.0, 250.0])
def test_stacked_is_one_instant_after_the_other(rate_hz: float) -> None:
    rng = np.random.default_rng(3)
    times = 5.0 + np.cumsum(rng.choice([0.0003, 0.002, 0.09], size=400, p=[0.6, 0.3, 0.1]))
    accel = rng.standard_normal((400, 3))
    accel[rng.random((400, 3)) < 0.3] = np.nan
    recording, model = Recording("r", times, {"accel": accel}), model_with_area(rate_hz)
    time_s, y = recording.stacked(model)
    np.testing.assert_array_equal(time_s, times)
    np.testing.assert_array_equal(y, one_by_one(recording, model, rate_hz))
    assert 0 < np.isfinite(y[:, 3]).sum() < 400


def test_measurements_are_the_rows_of_stacked() -> None:
    rng = np.random.default_rng(4)
    parts = {
        "accel": (np.arange(50) / 100, rng.standard_normal((50, 3))),
        "gyro": (np.arange(40) / 80 + 1e-3, rng.standard_normal((40, 3))),
        "camera": (np.arange(15) / 30, rng.standard_normal((15, 6))),
    }
    recording = Recording.from_sensors("r", parts)
    model = pen_model(load_pen("reference"), SENSORS, rest=False)
    time_s, y = recording.stacked(model)
    measured = list(recording.measurements(model))
    np.testing.assert_array_equal([m.time_s for m in measured], time_s)
    np.testing.assert_array_equal([m.y for m in measured], y)
    expected = np.hstack([recording.readings[name] for name in SENSORS])
    np.testing.assert_array_equal(y, expected)
    assert np.isnan(y).any(axis=0).all()


def test_a_hundred_thousand_instants() -> None:
    """At 1 kHz the area of 100 Hz speaks at every tenth."""
    n = 100_000
    y = recording_at(np.arange(n) / 1000).stacked(model_with_area(100.0))[1]
    np.testing.assert_array_equal(y[:, :3], np.tile(np.arange(n)[:, None], 3))
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(y[:, 3])), np.arange(0, n, 10))
    np.testing.assert_array_equal(y[::10, 3:], np.tile(CENTRE, (n // 10, 1)))


def test_the_recording_is_not_changed_by_writing_into_its_stacked_readings() -> None:
    recording = recording_at(np.arange(3.0))
    recording.stacked(model_with_area(None))[1][:] = 7.0
    np.testing.assert_array_equal(recording.readings["accel"][:, 0], [0, 1, 2])


@pytest.mark.parametrize(
    ("readings", "message"),
    [
        ({"accel": np.zeros((2, 2))}, r"accel has 2 columns, expected 3 \(x, y, z\)"),
        ({"gyro": np.zeros((2, 3))}, "no sensor accel; expected one of gyro"),
    ],
)
def test_stacked_refuses_what_does_not_fit(readings: dict[str, Array], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Recording("r", np.arange(2.0), readings).stacked(model_with_area(100.0))


def test_a_constant_reading_of_another_shape_is_refused() -> None:
    """Its size fits the model, its shape does not fit a reading."""
    model = model_with_area(None)
    accel, area = model.sensors
    area = dataclasses.replace(area, constant_reading=np.zeros((1, 3)))
    with pytest.raises(InputError, match=r"reading of area has shape \(1, 3\), expected \(3,\)"):
        recording_at(np.arange(2.0)).stacked(model.replace(sensors=(accel, area)))
