"""A sensor of rest in a pen file, and in the model that becomes of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from models.errors import InputError
from models.pen import pen_model
from models.pen_config import PenConfig
from models.sensor_kinds.table import SENSOR_KINDS
from models.state_space import StateSpaceModel
from recordings.simulate_pen import sensors_with_a_rate, simulate, simulate_model
from tests.estimation.resting import INERTIAL, pen_at_rest, pen_without_rest

Rest = SENSOR_KINDS["rest"]


def names(model: StateSpaceModel) -> list[str]:
    return [sensor.name for sensor in model.sensors]


def test_a_line_is_enough() -> None:
    rest: Any = Rest.model_validate({"kind": "rest"})
    assert (rest.std_rad_s, rest.window_s, rest.spread_factor) == (0.0005, 1.0, 2.5)
    assert rest.largest_bias_rad_s is None
    assert rest.is_detected


def test_any_unit() -> None:
    told = {"kind": "rest", "std_deg_s": 0.1, "window_ms": 500, "largest_bias_deg_s": 2}
    rest: Any = Rest.model_validate(told)
    assert rest.std_rad_s == pytest.approx(np.radians(0.1))
    assert rest.window_s == pytest.approx(0.5)
    assert rest.largest_bias_rad_s == pytest.approx(np.radians(2))


def test_it_reads_the_rate_of_the_body() -> None:
    model = pen_model(pen_at_rest(), INERTIAL)
    still, x = model.sensor("still"), model.prior.mean.copy()
    rates = [model.state_names.index(f"body_rate_{axis}_rad_s") for axis in "xyz"]
    x[rates] = [0.1, -0.2, 0.3]
    assert still.h(x).full().ravel() == pytest.approx(x[rates], abs=1e-15)
    assert still.residual(np.zeros(3), x).full().ravel() == pytest.approx(-x[rates], abs=1e-15)
    assert still.noise_std == pytest.approx([0.0005] * 3)


def test_it_goes_with_a_gyroscope() -> None:
    pen = pen_at_rest()
    assert names(pen_model(pen, INERTIAL)) == ["accel", "gyro", "area", "still"]
    assert names(pen_model(pen, ["accel"])) == ["accel", "area"]
    assert names(pen_model(pen, INERTIAL, rest=False)) == ["accel", "gyro", "area"]
    assert names(pen_model(pen, ["gyro", "still", "accel"])) == ["gyro", "still", "accel", "area"]
    assert names(pen_model(pen_without_rest(), INERTIAL)) == ["accel", "gyro", "area"]


def test_what_is_read_is_added_by_its_name_only() -> None:
    pen = pen_at_rest(is_detected=False)
    assert names(pen_model(pen, INERTIAL)) == ["accel", "gyro", "area"]
    model = pen_model(pen, (*INERTIAL, "still"))
    assert [sensor.name for sensor in model.measured_sensors] == ["accel", "gyro", "still"]


def test_nobody_reads_it_and_nothing_counts_it() -> None:
    """Consistency counts readings that bring noise: rest follows from others, detected or told."""
    for is_detected in (True, False):
        model = pen_model(pen_at_rest(is_detected=is_detected), (*INERTIAL, "still"))
        rows = model.measured_rows
        assert rows.sum() == 6
        assert not rows[6:9].any()
    assert names(pen_model(pen_at_rest(), INERTIAL).replace()) == ["accel", "gyro", "area", "still"]


def two(pen: PenConfig) -> PenConfig:
    return pen.model_copy(update={"sensors": {**pen.sensors, "calm": pen.sensors["still"]}})


@pytest.mark.parametrize(
    ("pen", "sensors", "words"),
    [
        (two(pen_at_rest()), ("gyro", "still", "calm"), "sensors still, calm detect rest"),
        (pen_at_rest(), ("accel", "still"), "still has no gyroscope to detect rest from"),
    ],
)
def test_refused(pen: PenConfig, sensors: tuple[str, ...], words: str) -> None:
    with pytest.raises(InputError, match=words):
        pen_model(pen, sensors)


def test_it_is_not_simulated() -> None:
    pen = pen_at_rest()
    assert "still" not in sensors_with_a_rate(pen)
    recording = simulate(pen, INERTIAL, duration_s=0.2)
    assert set(recording.readings) == set(INERTIAL)
    plain = simulate("reference", INERTIAL, duration_s=0.2)
    assert all((recording.readings[s] == plain.readings[s]).all() for s in INERTIAL)
    assert set(simulate_model(pen_model(pen, INERTIAL), duration_s=0.2).readings) == set(INERTIAL)
