"""Units recognised from the data: what is wrong is found, what is right is never doubted."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.units import STANDARD_GRAVITY_M_S2
from recordings.formats.tables import recording_from_table, recording_to_table
from recordings.plausible_units import check_units
from recordings.read import read_recording
from recordings.simulate_pen import simulate
from tests.recordings.swings import swinging

pytestmark = pytest.mark.usefixtures("interpreted")
DEG, G = np.pi / 180, STANDARD_GRAVITY_M_S2
PEN = load_pen("reference")
TURNED = [[0, -1, 0], [-1, 0, 0], [0, 0, -1]]
READ_RIGHT = {"accel": "m_s2", "gyro": "rad_s"}

# What was read as what → the sensor, the factor of its readings, the unit that it looks like.
WRONG_ACCELEROMETER = {
    "g as m_s2": ("accel", 1 / G, "g"),
    "mg as m_s2": ("accel", 1000 / G, "mg"),
    "m_s2 as g": ("accel", G, "m_s2"),
    "mg as g": ("accel", 1000.0, "mg"),
    "m_s2 as mg": ("accel", G / 1000, "m_s2"),
    "g as mg": ("accel", 1 / 1000, "g"),
}
WRONG_GYROSCOPE = {
    "deg_s as rad_s": ("gyro", 1 / DEG, "deg_s"),
    "rad_s as deg_s": ("gyro", DEG, "rad_s"),
}


def refused_in(recording: Recording, pen: PenConfig, what: str) -> str:
    """Read one sensor in a wrong unit; return the message."""
    name, factor, _ = (WRONG_ACCELEROMETER | WRONG_GYROSCOPE)[what]
    readings = {**recording.readings, name: recording.readings[name] * factor}
    wrong = dataclasses.replace(recording, readings=readings)
    with pytest.raises(InputError) as caught:
        check_units(wrong, pen, read_as=READ_RIGHT | {name: what.split(" as ")[1]})
    return str(caught.value)


def check_all(recording: Recording, pen: PenConfig, wrong: dict[str, Any]) -> None:
    """Right units pass; each wrong one is told apart from all others."""
    check_units(recording, pen)
    check_units(recording, pen, read_as=READ_RIGHT)
    for what, (name, _, looks_like) in wrong.items():
        message = refused_in(recording, pen, what)
        read = what.split(" as ")[1]
        assert f"{name} was read in {read} but looks like {looks_like} (" in message
        advice = f"expected --units {name}={looks_like} or headers like {name}_[xz]_{looks_like}$"
        assert re.search(advice, message)


@pytest.mark.parametrize("seed", range(30))
def test_a_hand_that_only_pushes_is_no_evidence(seed: int) -> None:
    """Gravity seems to turn, the gyroscope shows bias and noise: chance must not decide."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 5, 0.01)
    phases, frequencies = rng.uniform(0, 2 * np.pi, (8, 3)), rng.uniform(0.1, 3, (8, 1))
    push = sum(
        np.sin(2 * np.pi * f * t[:, None] + p) for f, p in zip(frequencies, phases, strict=True)
    )
    force = np.array([3.0, -2.0, 9.0]) + 0.2 * push
    rate = rng.normal(0, DEG, 3) + rng.normal(0, 0.1 * DEG, (len(t), 3))
    recording = Recording("pushed", t, {"accel": force, "gyro": rate})
    check_units(recording, PEN)


GENTLE = [("turn", 0.25, 12.0), ("turn", 1.0, 3.0), ("loops", 0.25, 12.0)]
GENTLE += [("handwriting", 1.0, 10.0), ("handwriting", 2.0, 10.0)]
FAST = [("turn", 2.0, 1.5), ("loops", 1.0, 3.0), ("yong", 1.0, 3.0), ("handwriting", 4.0, 10.0)]


@pytest.mark.parametrize(("motion", "speed", "duration_s"), GENTLE)
def test_simulated_motions(motion: str, speed: float, duration_s: float) -> None:
    recording = simulate(
        PEN, ["accel", "gyro"], motion=motion, duration_s=duration_s, seed=1, speed=speed
    )
    check_all(recording, PEN, WRONG_ACCELEROMETER | WRONG_GYROSCOPE)


@pytest.mark.parametrize(("motion", "speed", "duration_s"), FAST)
def test_fast_motions_are_not_doubted(motion: str, speed: float, duration_s: float) -> None:
    """The hand's acceleration hides how gravity turns: no word on the gyroscope."""
    recording = simulate(
        PEN, ["accel", "gyro"], motion=motion, duration_s=duration_s, seed=1, speed=speed
    )
    check_all(recording, PEN, WRONG_ACCELEROMETER)
    rates = {**recording.readings, "gyro": recording.readings["gyro"] * DEG}
    check_units(dataclasses.replace(recording, readings=rates), PEN)


def test_a_pen_at_rest_says_nothing_of_its_gyroscope() -> None:
    recording = simulate(PEN, ["accel", "gyro"], motion="still", duration_s=10.0, seed=1)
    check_all(recording, PEN, WRONG_ACCELEROMETER)
    for factor in (DEG, 1 / DEG):
        readings = {**recording.readings, "gyro": recording.readings["gyro"] * factor}
        check_units(dataclasses.replace(recording, readings=readings), PEN)


def with_rates(rates: Array) -> Recording:
    """A gyroscope alone."""
    return Recording("spun", np.arange(len(rates)) * 0.01, {"gyro": rates})


def test_largest_rates_without_an_accelerometer() -> None:
    rng = np.random.default_rng(0)
    fast = with_rates(np.clip(rng.normal(0, 1500 * DEG, (1000, 3)), -2000 * DEG, 2000 * DEG))
    check_units(fast, PEN)
    message = refused_in(fast, PEN, "deg_s as rad_s")
    assert re.search(r"gyro was read in rad_s but looks like deg_s \(one in a hundred", message)
    # A few outliers, or slow rates, are no evidence; nor is what no unit explains.
    few = with_rates(
        np.where(np.arange(1000)[:, None] % 200 == 0, 500.0, rng.normal(0, 1, (1000, 3)))
    )
    check_units(few, PEN)
    check_units(with_rates(rng.normal(0, 10, (1000, 3))), PEN)
    check_units(with_rates(rng.normal(0, 1e4, (1000, 3))), PEN, read_as={"gyro": "deg_s"})


def test_a_gyroscope_may_have_a_larger_range() -> None:
    gyro = PEN.sensors["gyro"].model_copy(update={"range_rad_s": 8000 * DEG})
    pen = PEN.model_copy(update={"sensors": {**PEN.sensors, "gyro": gyro}})
    rates = np.random.default_rng(0).normal(0, 2000 * DEG, (1000, 3))
    check_units(with_rates(rates), pen)
    with pytest.raises(InputError, match="looks like deg_s"):
        check_units(with_rates(rates), PEN)


def test_what_no_unit_explains_is_accepted() -> None:
    t = np.arange(0, 1, 0.01)
    for norm in (0.01, 3.0, 30.0, 1e5):
        recording = Recording("odd", t, {"accel": np.full((len(t), 3), norm / np.sqrt(3))})
        check_units(recording, PEN)


def test_gravity_is_the_pen_s() -> None:
    """On the moon 1.62 m/s² are no g."""
    t = np.arange(0, 1, 0.01)
    recording = Recording("moon", t, {"accel": np.tile([0.0, 0.0, 1.62], (len(t), 1))})
    check_units(recording, PEN.model_copy(update={"gravity_m_s2": 1.62}))
    with pytest.raises(InputError, match=r"its norm is 1\.62 m/s2, but gravity 9\.81"):
        check_units(recording, PEN)


def test_fewer_axes_and_partial_readings() -> None:
    t, rate, up = swinging(3)
    force = np.where(np.arange(len(t))[:, None] % 5 == 0, [np.nan, 1.0, 1.0], 1.0) * G * up
    recording = Recording("partial", t, {"accel": force, "gyro": rate})
    check_all(recording, PEN, WRONG_ACCELEROMETER | WRONG_GYROSCOPE)
    two = PEN.sensors["accel"].model_copy(update={"axes": ("z", "x")})
    pen = PEN.model_copy(update={"sensors": {"accel": two, "gyro": PEN.sensors["gyro"]}})
    in_g = Recording("two axes", t, {"accel": up[:, [2, 0]], "gyro": rate})
    check_units(in_g, pen)


def test_mounting_and_order_of_axes_are_respected() -> None:
    t, rate, up = swinging(4)
    accel = PEN.sensors["accel"].model_copy(update={"sensor_to_body": TURNED})
    gyro = PEN.sensors["gyro"].model_copy(update={"axes": ("z", "x", "y")})
    pen = PEN.model_copy(update={"sensors": {"accel": accel, "gyro": gyro}})
    readings = {"accel": G * up @ np.array(TURNED), "gyro": rate[:, [2, 0, 1]]}
    check_all(Recording("mounted", t, readings), pen, WRONG_ACCELEROMETER | WRONG_GYROSCOPE)


def test_a_sensor_whose_unit_is_unknown_is_not_checked() -> None:
    t, rate, up = swinging(5)
    check_units(Recording("mixed", t, {"accel": up, "gyro": rate / DEG}), PEN, read_as={})


def test_the_real_pen(dpoint_folder: Path) -> None:
    pen = load_pen("dpoint")
    table = recording_to_table(read_recording(dpoint_folder, pen), pen)
    recording = recording_from_table(table, pen, "dpoint")
    check_all(recording, pen, WRONG_ACCELEROMETER | WRONG_GYROSCOPE)
    for start_s in range(0, 36, 3):
        part = (recording.time_s >= start_s) & (recording.time_s < start_s + 5)
        readings = {name: values[part] for name, values in recording.readings.items()}
        check_units(Recording("part", recording.time_s[part], readings), pen)


@pytest.mark.parametrize(
    "unit", [0, 1, *(pytest.param(k, marks=pytest.mark.slow) for k in range(2, 8))]
)
def test_a_shaken_array(data_folder: Path, unit: int) -> None:
    """Still poses, turns by hand, then shaking at up to 4000 deg/s; also the shaking alone."""
    path = data_folder / "isa_imu_array" / "exp_1_raw_int16.npz"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    raw = np.load(path)
    mounting = {"bandwidth_hz": 30.0, "sensor_to_body": TURNED if unit % 2 else np.eye(3).tolist()}
    pen = PenConfig(
        name="array",
        sensors={
            "accel": {"kind": "accelerometer", "noise_density_m_s2_per_sqrt_hz": 0.01, **mounting},
            "gyro": {"kind": "gyroscope", "noise_density_rad_s_per_sqrt_hz": 0.001, **mounting},
        },
    )
    t = raw["t"] - raw["t"][0]
    readings = {"accel": raw["acc"][:, unit] / 2048 * G, "gyro": raw["gyr"][:, unit] / 16.4 * DEG}
    check_all(Recording("array", t, readings), pen, WRONG_ACCELEROMETER | WRONG_GYROSCOPE)
    shaken = t > 510
    part = Recording("shaken", t[shaken], {name: v[shaken] for name, v in readings.items()})
    check_units(part, pen)
    check_units(part, pen, read_as={"accel": "g", "gyro": "deg_s"})
    assert "looks like deg_s" in refused_in(part, pen, "deg_s as rad_s")
