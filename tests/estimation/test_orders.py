"""Rows that are stacked part by part are those of the whole recording."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest

from estimation.orders import InOrderOfArrival, InOrderOfCapture, Stacked
from estimation.recording import Recording
from estimation.recording_parts import joined
from models.pen import pen_model
from models.pen_file import load_pen
from recordings.simulate_pen import simulate

PEN = load_pen("reference")
SENSORS = ("accel", "gyro", "camera")


@pytest.fixture(scope="module")
def recorded() -> Recording:
    """Half a second; the camera is late, by turns more, and once later than everything else."""
    recording = simulate(PEN, SENSORS, motion="still", duration_s=0.5)
    late = recording.arrivals["camera"].copy()
    late[::3] += 0.03
    late[2] = 7.0 if np.isfinite(late[2]) else np.nan
    return dataclasses.replace(recording, arrivals={"camera": late})


def parts(recording: Recording, rows: int) -> Iterator[Recording]:
    number = np.arange(len(recording.time_s)) // rows
    for part in range(number[-1] + 1):
        yield recording.some_rows(number == part)


def taken(order: InOrderOfCapture | InOrderOfArrival, given: Iterator[Recording]) -> Stacked:
    found = [*map(order.take, given), order.end()]
    return Stacked(
        np.concatenate([rows.time_s for rows in found]),
        np.concatenate([rows.y for rows in found]),
        np.concatenate([rows.arrival_s for rows in found]),
    )


@pytest.mark.cover
@pytest.mark.parametrize("rows", [1, 4, 7, 16, 1000])
@pytest.mark.parametrize("area_hz", [100.0, 7.0])
def test_rows_are_those_of_the_whole(recorded: Recording, rows: int, area_hz: float) -> None:
    """A writing area speaks once in each of its periods, whatever the parts."""
    area = PEN.sensors["area"].model_copy(update={"rate_hz": area_hz})
    pen = PEN.model_copy(update={"sensors": {**PEN.sensors, "area": area}})
    model = pen_model(pen, (*SENSORS, "area"))
    assert model.sensor("area").constant_reading is not None
    captured = taken(InOrderOfCapture(model), parts(recorded, rows))
    time_s, y = recorded.stacked(model)
    np.testing.assert_array_equal(captured.time_s, time_s)
    np.testing.assert_array_equal(captured.y, y)
    arrived = taken(InOrderOfArrival(model), parts(recorded, rows))
    for found, whole in zip(
        (arrived.time_s, arrived.y, arrived.arrival_s), recorded.as_arrived(model), strict=True
    ):
        np.testing.assert_array_equal(found, whole)


def test_joined_parts_are_the_whole(recorded: Recording) -> None:
    again = joined(list(parts(recorded, 7)))
    np.testing.assert_array_equal(again.time_s, recorded.time_s)
    for sensor, readings in recorded.readings.items():
        np.testing.assert_array_equal(again.readings[sensor], readings)
    np.testing.assert_array_equal(again.arrivals["camera"], recorded.arrivals["camera"])
