"""A pen is found in a recording: what is measured is so, what is not is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.pen_file import load_pen
from pen_mhe.estimate_run import estimate
from pen_mhe.no_pen.axis import AXES, read_axis
from pen_mhe.no_pen.found_pen import FoundPen
from pen_mhe.no_pen.pen_for import pen_for
from pen_mhe.no_pen.stamps import stamp_jitter_s
from tests.recordings.rods import proper_mountings
from tests.references.leaning_rod import LeaningRod, leaning_rod

MOUNTINGS = proper_mountings()


def recorded(rod: LeaningRod, *, accel: bool = True, gyro: bool = True) -> Recording:
    sensors = {}
    if accel:
        sensors["accel"] = (rod.time_s, rod.force)
    if gyro:
        sensors["gyro"] = (rod.time_s, rod.rate)
    return Recording.from_sensors("rod.csv", sensors)


def sensor(found: FoundPen, name: str) -> object:
    return found.pen.sensors[name]


def said(found: FoundPen, start: str) -> str:
    return next(note for note in found.notes if note.startswith(start))


@pytest.mark.parametrize("number", range(0, 24, 3))
def test_the_axis_and_the_place_are_those_of_the_rod(number: int) -> None:
    rod = leaning_rod(number, MOUNTINGS[number], lever_m=0.07)
    found = pen_for(recorded(rod))
    chip = found.pen.sensors["accel"]
    np.testing.assert_allclose(np.array(chip.sensor_to_body)[2], MOUNTINGS[number][2], atol=1e-9)
    np.testing.assert_allclose(chip.position_m, (0, 0, 0.07), atol=0.004)
    assert "the motion turns about a point along it" in said(found, "axis: ")


def test_noise_and_bias_are_those_at_rest() -> None:
    rod = leaning_rod(1, MOUNTINGS[5])
    pen = pen_for(recorded(rod)).pen
    still = rod.rate[rod.time_s < 2.9]
    assert pen.sensors["accel"].sample_std == pytest.approx(0.012, rel=0.15)
    assert pen.sensors["gyro"].sample_std == pytest.approx(np.radians(0.08), rel=0.15)
    np.testing.assert_allclose(pen.sensors["gyro"].bias, still.mean(axis=0), atol=1e-4)
    assert pen.sensors["rest"].is_rest


def test_a_second_of_rest_in_a_minute_is_found() -> None:
    found = pen_for(recorded(leaning_rod(2, MOUNTINGS[0], duration_s=60.0, rest_s=2.0)))
    assert "measured in" in said(found, "rest: ")


def test_without_rest_it_says_so_and_knows_less() -> None:
    found = pen_for(recorded(leaning_rod(3, MOUNTINGS[7], rest_s=-1.0)))
    assert "never still" in said(found, "rest: ")
    resting = pen_for(recorded(leaning_rod(3, MOUNTINGS[7])))
    for name, key in (("accel", "bias_std_m_s2"), ("gyro", "bias_std_rad_s")):
        assert getattr(sensor(found, name), key) > getattr(sensor(resting, name), key)
    assert found.pen.prior.elevation_std_rad > resting.pen.prior.elevation_std_rad


@pytest.mark.parametrize("number", [2, 7, 11, 20])
def test_the_axis_of_a_pen_that_never_rests_is_seen_too(number: int) -> None:
    """By what turns it; by gravity alone a pen that leans by 45° may point either way."""
    rod = leaning_rod(number, MOUNTINGS[number], lever_m=0.07, rest_s=-1.0)
    found = pen_for(recorded(rod))
    chip = found.pen.sensors["accel"]
    np.testing.assert_allclose(np.array(chip.sensor_to_body)[2], MOUNTINGS[number][2], atol=1e-9)
    np.testing.assert_allclose(chip.position_m, (0, 0, 0.07), atol=0.006)
    assert "measured: the motion turns about a point along it" in said(found, "axis: ")


def test_a_guessed_axis_is_a_remark_of_the_answer() -> None:
    """Where the tip moves and two axes are as upright, nothing tells which is the pen's."""
    for lean, is_guessed in ((45.0, True), (15.0, False)):
        rng, t = np.random.default_rng(1), np.arange(0, 6, 0.01)
        up = np.array([np.sin(np.radians(lean)), 0.0, np.cos(np.radians(lean))])
        force = 9.81 * up + rng.normal(0, 0.3, (len(t), 3))
        sensors = {"accel": (t, force), "gyro": (t, rng.normal(0, 0.3, force.shape))}
        run = estimate(Recording.from_sensors("it", sensors), estimator="ekf")
        assert ("guessed axis" in " ".join(run.sentences())) == is_guessed
        assert ("is guessed to point" in " ".join(run.sentences())) == is_guessed
        told = estimate(Recording.from_sensors("it", sensors), axis="z", estimator="ekf")
        assert "guessed axis" not in " ".join(told.sentences())


def test_an_axis_that_is_told_is_taken() -> None:
    rod = recorded(leaning_rod(4, MOUNTINGS[0]))
    for name in AXES:
        chip = pen_for(rod, name).pen.sensors["gyro"]
        np.testing.assert_allclose(np.array(chip.sensor_to_body)[2], read_axis(name).direction)
    rows = np.array(pen_for(rod, "0.1,-0.2,0.9").pen.sensors["gyro"].sensor_to_body)
    np.testing.assert_allclose(rows[2] * np.sqrt(0.86), (0.1, -0.2, 0.9), atol=1e-6)


@pytest.mark.parametrize("axis", ["w", "x,y,z", "0,0,0", "1,2", "nan,0,1", "", "--z"])
def test_an_axis_that_is_none_is_refused(axis: str) -> None:
    with pytest.raises(InputError, match="expected one of x, -x, y, -y, z, -z, or three numbers"):
        read_axis(axis)


def test_the_file_says_the_same_and_an_edited_one_stays(tmp_path: Path) -> None:
    found, path = pen_for(recorded(leaning_rod(5, MOUNTINGS[1]))), tmp_path / "rod_pen.toml"
    found.write(path)
    assert load_pen(path) == found.pen
    found.write(path)
    path.write_text(path.read_text().replace("9.81", "9.80"))
    with pytest.raises(InputError, match="was edited, expected --pen"):
        found.write(path)
    assert "9.80" in path.read_text()


def test_every_number_says_where_it_comes_from() -> None:
    found = pen_for(recorded(leaning_rod(6, MOUNTINGS[2])))
    for line in found.text.splitlines():
        if " = " in line and '"' not in line and not line.startswith("#"):
            assert any(f"# {origin}" in line for origin in ("measured", "assumed", "told")), line


def test_one_sensor_alone_is_a_pen_that_says_what_is_missing() -> None:
    rod = leaning_rod(7, MOUNTINGS[0])
    slow = pen_for(recorded(rod, gyro=False))
    assert list(slow.pen.sensors) == ["accel"]
    blind = pen_for(recorded(rod, accel=False))
    assert list(blind.pen.sensors) == ["gyro", "rest"]
    assert "no accelerometer shows gravity" in said(blind, "axis: ")


def test_an_accelerometer_without_gravity_is_left_out() -> None:
    rod = leaning_rod(8, MOUNTINGS[0])
    flat = Recording.from_sensors(
        "rod", {"accel": (rod.time_s, rod.force % 0.2), "gyro": (rod.time_s, rod.rate)}
    )
    found = pen_for(flat)
    assert "accel" not in found.pen.sensors
    assert "no gravity in it" in said(found, "accel")
    with pytest.raises(InputError, match="no gravity in it"):
        pen_for(flat.select(["accel"]))


def test_what_has_no_sensor_of_these_kinds_is_refused() -> None:
    other = Recording("knob", np.array([0.0, 1.0]), {"knob": np.zeros((2, 1))})
    with pytest.raises(InputError, match="expected one of accel, gyro, camera"):
        pen_for(other)


def test_the_jitter_of_stamps_is_noise() -> None:
    calm, hasty = (leaning_rod(9, MOUNTINGS[0], jitter_s=s) for s in (0.0, 0.003))
    assert stamp_jitter_s(calm.time_s) < 1e-6
    assert stamp_jitter_s(hasty.time_s) == pytest.approx(0.003, rel=0.3)
    noise = [pen_for(recorded(rod)).pen.sensors["gyro"].sample_std for rod in (calm, hasty)]
    assert noise[1] > 5 * noise[0]
    assert "stamps jitter" in pen_for(recorded(hasty)).text


def errors_deg(rod: LeaningRod) -> Array:
    run = estimate(recorded(rod), estimator="mhe-rti")
    error = np.degrees(run.output.column("elevation_rad") - rod.elevation)
    return np.asarray(error[rod.time_s >= 1])


@pytest.mark.slow
@pytest.mark.parametrize("jitter_s", [0.0, 0.003])
@pytest.mark.parametrize("tip_m", [0.0, 0.01])
def test_elevation_is_known_better_than_the_bias_lets_a_still_pen_know_it(
    tip_m: float, jitter_s: float
) -> None:
    rods = [
        leaning_rod(seed, MOUNTINGS[seed % 24], tip_m=tip_m, jitter_s=jitter_s)
        for seed in range(500, 512)
    ]
    squares = [np.mean(errors_deg(rod) ** 2) for rod in rods]
    tilts = [np.degrees(rod.bias_tilt) ** 2 for rod in rods]
    assert np.sqrt(np.mean(squares)) < np.sqrt(np.mean(tilts))
    assert np.sqrt(np.median(squares)) < 0.6
