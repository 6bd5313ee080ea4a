"""A name that nothing has gets a sentence with the one that was meant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from models.body_model import choose_sensors
from models.errors import InputError
from models.motions import motion_named
from models.names import did_you_mean, nearest, unknown
from models.pen_file import load_pen, parse_pen

SENSORS = ("accel", "gyro", "camera", "accel_lower", "contact")


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("gyr", "gyro"),
        ("acel", "accel"),
        ("CAMERA", "camera"),
        ("gyroscope", "gyro"),
        ("accelerometer", "accel"),
        ("lower", "accel_lower"),
        ("radar", None),
        ("", None),
        ("a", None),
    ],
)
def test_the_nearest_name(typed: str, meant: str | None) -> None:
    assert nearest(typed, SENSORS) == meant
    assert did_you_mean(typed, SENSORS) == (f"; did you mean {meant}?" if meant else "")


def test_a_name_is_given_back_as_it_is_spelt() -> None:
    assert nearest("lsm6ds3-gyro", ("ADXL202", "LSM6DS3-gyroscope")) == "LSM6DS3-gyroscope"


def test_the_sentence_has_all_names_and_the_one_that_was_meant() -> None:
    assert str(unknown("motion", "tern", ("turn", "still"))) == (
        "motion tern is unknown, expected one of turn, still; did you mean turn?"
    )
    assert str(unknown("motion", "x", ("turn", "still"))) == (
        "motion x is unknown, expected one of turn, still"
    )
    assert isinstance(unknown("motion", 3, iter(["turn"])), InputError)


PEN: dict[str, Any] = {"name": "p", "sensors": {"tip": {"kind": "accelerometr", "rate_hz": 5}}}
PEN_OF_ADXL202 = {"name": "p", "sensors": {"a": {"preset": "ADXL202"}}}


@pytest.mark.parametrize(
    ("use", "meant"),
    [
        (lambda: choose_sensors(dict.fromkeys(SENSORS), ["gyr"], "pen p"), "gyro"),
        (lambda: motion_named("uprite"), "upright"),
        (lambda: load_pen("referense"), "reference"),
        (lambda: parse_pen(PEN), "accelerometer"),
        (lambda: parse_pen({"name": "p", "sensors": {"a": {"preset": "ADXL20"}}}), "ADXL202"),
        (lambda: parse_pen({**PEN_OF_ADXL202, "bouns": {}}), "bounds"),
    ],
)
def test_whoever_looks_a_name_up_says_what_was_meant(use: Callable[[], object], meant: str) -> None:
    with pytest.raises(InputError, match=rf"; did you mean {meant}\?"):
        use()
