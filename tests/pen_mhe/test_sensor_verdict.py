"""The verdict on the sensors of whole pens, along motions of the table."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from estimation.recording import Recording, Truth
from models.errors import InputError
from models.free_pen import STATES
from models.motion import white_jerk_motion
from models.motions import sample_motion
from models.pen import pen_model
from models.pen_file import load_pen
from pen_mhe.sensor_verdict import MOTIONS, SensorVerdict, judge, observe
from recordings.simulate_pen import simulate

pytestmark = pytest.mark.usefixtures("interpreted")

SECONDS = 1.0
RATES = {f"body_rate_{axis}_rad_s" for axis in "xyz"}
HEADING = "turning about the vertical"


@cache
def found(pen: str, sensors: tuple[str, ...], writing_area: bool = True) -> SensorVerdict:
    level = load_pen(pen).model_copy(update={"level_rad": (0.0, 0.0)})
    return observe(level, sensors, writing_area=writing_area, duration_s=SECONDS)


def words(verdicts: SensorVerdict, motion: str) -> list[str]:
    return [d.words for d in verdicts.by_motion[motion].observability.directions]


def outputs(verdicts: SensorVerdict) -> tuple[str, ...]:
    return next(iter(verdicts.by_motion.values())).bound.names


def unseen(verdicts: SensorVerdict, motion: str) -> set[str]:
    names = outputs(verdicts)
    return {name for name in names if not verdicts.by_motion[motion].sees(name)}


@pytest.mark.parametrize("motion", MOTIONS)
def test_both_inertial_sensors_see_tilt_and_rates_but_no_azimuth(motion: str) -> None:
    verdicts = found("reference", ("accel", "gyro"))
    assert "azimuth_rad" in unseen(verdicts, motion)
    seen = set(outputs(verdicts)) - unseen(verdicts, motion)
    assert RATES | {"elevation_rad", "spin_rad"} <= seen


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_camera_shows_everything(motion: str) -> None:
    verdicts = found("reference", ("accel", "gyro", "camera"))
    assert unseen(verdicts, motion) == set()
    assert words(verdicts, motion) == []


def test_a_lone_accelerometer_does_not_see_what_turns_about_the_vertical() -> None:
    """At rest a turn and its rate; its acceleration is mixed up with tilt."""
    verdicts = found("reference", ("accel",))
    turn, rate, acceleration, *_ = words(verdicts, "still")
    assert [turn, rate] == [f"{HEADING} alone", f"rate of {HEADING} alone"]
    assert acceleration.startswith("angular acceleration about the vertical by 1 with turning")
    assert {"azimuth_rad", *RATES} <= unseen(verdicts, "still")
    assert "azimuth_rad" in unseen(verdicts, "handwriting")


def test_two_accelerometers_see_a_rate_about_the_vertical_only_in_motion() -> None:
    """As it enters squared: its slope is zero at rest."""
    verdicts = found("reference", ("accel_lower", "accel_upper"))
    assert words(verdicts, "still") == [f"{HEADING} alone", f"rate of {HEADING} alone"]
    (heading,) = verdicts.by_motion["handwriting"].observability.directions
    assert next(iter(heading.changes)) == HEADING
    assert f"rate of {HEADING}" not in heading.changes


def test_a_lone_gyroscope_sees_no_attitude() -> None:
    """Neither at rest nor, as its rates are the body's, in any motion."""
    verdicts = found("reference", ("gyro",))
    turns = ["turning about world x", "turning about world y", HEADING]
    assert words(verdicts, "still")[:3] == [f"{turn} alone" for turn in turns]
    assert words(verdicts, "handwriting")[:3] == [f"{turn} alone" for turn in turns]
    for motion in MOTIONS:
        assert {"azimuth_rad", "elevation_rad", "spin_rad"} <= unseen(verdicts, motion)
        fractions = verdicts.by_motion[motion].unseen_fraction
        # 1 but for the geometry: the axis of an elevation goes with the azimuth.
        assert fractions[outputs(verdicts).index("elevation_rad")] > 0.95


@pytest.mark.parametrize("sensors", [("accel", "gyro"), ("gyro",)])
def test_a_tip_beside_its_areas_centre_is_as_one_in_the_centre(sensors: tuple[str, ...]) -> None:
    """The D-POINT pen's area lies around (0.1, 0.1) m, the motions start in the origin."""
    verdicts = found("dpoint", sensors)
    area = verdicts.model.sensor("area").constant_reading
    assert area is not None
    tip = sample_motion("still", np.zeros(1)).q[0, :3]
    assert np.linalg.norm(area[:2] - tip[:2]) > 0.1
    assert f"{HEADING} alone" in words(verdicts, "still")
    named = {n for d in verdicts.by_motion["still"].observability.directions for n in d.changes}
    assert not {name for name in named if name.startswith("tip_")}


def test_without_an_area_nothing_holds_the_tip() -> None:
    """Its velocity, either, but for what the hand does not do: white jerk does everything."""
    verdicts = found("reference", ("accel", "gyro"), writing_area=False)
    assert [sensor.name for sensor in verdicts.model.sensors] == ["accel", "gyro", "rest"]
    places = {name for name, unit in STATES if unit == "m"}
    tip = places | {name for name, unit in STATES if unit == "m/s"}
    old = load_pen("reference").model_copy(update={"motion": white_jerk_motion(100.0, 1000.0)})
    lively = observe(old, ("accel", "gyro"), writing_area=False, duration_s=SECONDS)
    for motion in MOTIONS:
        assert {f"{name} alone" for name in places} <= set(words(verdicts, motion))
        assert {f"{name} alone" for name in tip} <= set(words(lively, motion))
        for found_of in (verdicts, lively):
            assert tip <= unseen(found_of, motion)


def test_a_motion_shows_no_less_than_rest() -> None:
    """And more, but to a gyroscope."""
    for sensors in (("accel",), ("gyro",), ("accel", "gyro"), ("accel_lower", "accel_upper")):
        by_motion = found("reference", sensors).by_motion
        assert tuple(by_motion) == MOTIONS
        ranks = [by_motion[motion].observability.rank for motion in MOTIONS]
        assert ranks[0] == ranks[1] if sensors == ("gyro",) else ranks[0] < ranks[1]


@cache
def turn() -> Recording:
    return simulate(load_pen("reference"), ("accel", "gyro"), motion="turn", duration_s=0.3, seed=2)


def test_the_verdict_depends_on_which_readings_there_are_not_on_their_values() -> None:
    model = pen_model(load_pen("reference"), ("accel", "gyro"))
    one = judge(model, turn())
    zeros = {name: np.where(np.isnan(y), y, 0.0) for name, y in turn().readings.items()}
    same = judge(model, dataclasses.replace(turn(), readings=zeros))
    np.testing.assert_array_equal(one.unseen_fraction, same.unseen_fraction)
    gaps = {**turn().readings, "gyro": np.full_like(turn().readings["gyro"], np.nan)}
    less = judge(model, dataclasses.replace(turn(), readings=gaps))
    rate = one.bound.names.index("body_rate_z_rad_s")
    assert less.unseen_fraction[rate] > 2 * one.unseen_fraction[rate]


def test_bad_input_is_refused() -> None:
    pen, recording = load_pen("reference"), turn()
    model = pen_model(pen, ("accel", "gyro"))
    with pytest.raises(InputError, match="motion dance is unknown, expected one of turn, still"):
        observe(pen, ("gyro",), motions=["dance"])
    with pytest.raises(InputError, match="duration is 0 s, expected a positive time"):
        observe(pen, ("gyro",), duration_s=0)
    with pytest.raises(InputError, match="no truth, expected it to judge by"):
        judge(model, dataclasses.replace(recording, truth=None))
    truth = recording.truth
    assert truth is not None
    kinematic = Truth(truth.time_s, truth.names[:18], truth.values[:, :18])
    with pytest.raises(InputError, match=r"truth lacks accel_bias_x_m_s2, .*, gyro_bias_z_rad_s"):
        judge(model, dataclasses.replace(recording, truth=kinematic))
