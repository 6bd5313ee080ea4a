"""The verdict on the sensors of whole pens, along motions of the table."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from estimation.recording import Recording, Truth
from models.errors import InputError
from models.euler_pen import kinematic_states
from models.motions import sample_motion
from models.pen import pen_model
from models.pen_file import load_pen
from pen_mhe.sensor_verdict import MOTIONS, SensorVerdict, judge, observe
from recordings.simulate_pen import simulate

pytestmark = pytest.mark.usefixtures("interpreted")

SECONDS = 1.0


@cache
def found(pen: str, sensors: tuple[str, ...], writing_area: bool = True) -> SensorVerdict:
    return observe(load_pen(pen), sensors, writing_area=writing_area, duration_s=SECONDS)


def words(verdicts: SensorVerdict, motion: str) -> list[str]:
    return [d.words for d in verdicts.by_motion[motion].observability.directions]


def unseen(verdicts: SensorVerdict, motion: str) -> set[str]:
    names = verdicts.model.state_names
    return {name for name in names if not verdicts.by_motion[motion].sees(name)}


@pytest.mark.parametrize("motion", MOTIONS)
def test_both_inertial_sensors_see_tilt_and_rates_but_no_azimuth(motion: str) -> None:
    verdicts = found("reference", ("accel", "gyro"))
    assert "azimuth_rad" in unseen(verdicts, motion)
    seen = set(verdicts.model.state_names) - unseen(verdicts, motion)
    rates = {f"{angle}_rate_rad_s" for angle in ("azimuth", "elevation", "spin")}
    assert rates | {"elevation_rad", "spin_rad"} <= seen


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_camera_shows_everything(motion: str) -> None:
    verdicts = found("reference", ("accel", "gyro", "camera"))
    assert unseen(verdicts, motion) == set()
    assert words(verdicts, motion) == []


def test_a_lone_accelerometer_does_not_see_what_turns_about_the_vertical() -> None:
    """At rest azimuth and its rate; its acceleration is mixed up with tilt."""
    verdicts = found("reference", ("accel",))
    assert words(verdicts, "still")[:2] == ["azimuth_rad alone", "azimuth_rate_rad_s alone"]
    assert {"azimuth_rad", "azimuth_rate_rad_s"} <= unseen(verdicts, "still")
    assert "azimuth_rad" in unseen(verdicts, "handwriting")


def test_two_accelerometers_see_the_azimuths_rate_only_in_motion() -> None:
    """As it enters squared: its slope is zero at rest."""
    verdicts = found("reference", ("accel_lower", "accel_upper"))
    assert words(verdicts, "still") == ["azimuth_rad alone", "azimuth_rate_rad_s alone"]
    (heading,) = verdicts.by_motion["handwriting"].observability.directions
    assert next(iter(heading.changes)) == "azimuth_rad"
    assert "azimuth_rate_rad_s" not in heading.changes


def test_a_lone_gyroscope_sees_no_attitude_at_rest() -> None:
    verdicts = found("reference", ("gyro",))
    angles = ["azimuth_rad", "elevation_rad", "spin_rad"]
    assert words(verdicts, "still")[:3] == [f"{angle} alone" for angle in angles]
    assert set(angles) <= unseen(verdicts, "still")


@pytest.mark.parametrize("sensors", [("accel", "gyro"), ("gyro",)])
def test_a_tip_beside_its_areas_centre_is_as_one_in_the_centre(sensors: tuple[str, ...]) -> None:
    """The D-POINT pen's area lies around (0.1, 0.1) m, the motions start in the origin."""
    verdicts = found("dpoint", sensors)
    area = verdicts.model.sensor("area").constant_reading
    assert area is not None
    tip = sample_motion("still", np.zeros(1)).q[0, :3]
    assert np.linalg.norm(area[:2] - tip[:2]) > 0.1
    assert words(verdicts, "still")[0] == "azimuth_rad alone"
    named = {n for d in verdicts.by_motion["still"].observability.directions for n in d.changes}
    assert not {name for name in named if name.startswith("tip_")}


def test_without_an_area_nothing_holds_the_tip() -> None:
    verdicts = found("reference", ("accel", "gyro"), writing_area=False)
    assert [sensor.name for sensor in verdicts.model.sensors] == ["accel", "gyro"]
    tip = [name for name, unit in kinematic_states(6) if unit in ("m", "m/s")]
    for motion in MOTIONS:
        assert {f"{name} alone" for name in tip} <= set(words(verdicts, motion))
        assert set(tip) <= unseen(verdicts, motion)


def test_a_motion_shows_no_less_than_rest() -> None:
    for sensors in (("accel",), ("gyro",), ("accel", "gyro"), ("accel_lower", "accel_upper")):
        by_motion = found("reference", sensors).by_motion
        assert tuple(by_motion) == MOTIONS
        ranks = [by_motion[motion].observability.rank for motion in MOTIONS]
        assert ranks[0] < ranks[1]


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
    rate = model.state_names.index("spin_rate_rad_s")
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
