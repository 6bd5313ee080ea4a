"""Calibration by a camera's frames: it finds the truth, as well as it says, or says why not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pen_mhe as pm
from models.errors import InputError
from pen_mhe.calibration import frames
from pen_mhe.calibration.camera import calibrate_camera
from pen_mhe.calibration.camera_result import CameraCalibration
from pen_mhe.calibration.frames import Frames
from pen_mhe.calibration.mounted_filter import MountedFilter
from pen_mhe.calibration.mounting import (
    HEIGHT,
    LEVEL,
    LEVER,
    OFFSET,
    SLOPE,
    TURN,
    numbers_of,
)
from pen_mhe.calibration.mounting_keys import new_values
from pen_mhe.tuning.parameters import with_values
from tests.pen_mhe.calibration.mounted import SENSORS, Array, handwriting_pen, mounted

WITH_CONTACT = (*SENSORS, "contact")
LARGEST_STD = np.array([2.0] + [0.3] * 3 + [2.0] * 3 + [0.2] * 2)
"""Deviations that are demanded: ms, degrees, mm, degrees."""
NAMES = ["offset", *(f"{q} {a}" for q in ("turn", "lever") for a in "xyz"), "level x", "level y"]


def found(seed: int, duration_s: float = 40.0) -> tuple[Array, Array]:
    """Return errors and deviations (9,) in their units, with everything free."""
    truth = mounted(seed, duration_s)
    whole = calibrate_camera(truth.recording, handwriting_pen()).whole
    factors = np.array([n.quantity.factor for n in numbers_of(handwriting_pen(), SENSORS)])
    return factors * (whole.values - truth.values), factors * whole.std


@pytest.mark.slow
def test_errors_are_as_large_as_the_deviations_say() -> None:
    """50 runs of 40 s; two of the numbers may have 84 %."""
    errors, stds = map(np.array, zip(*(found(100 + seed) for seed in range(50)), strict=True))
    within = (np.abs(errors) <= 2 * stds).mean(axis=0)
    shown = dict(zip(NAMES, within.round(2).tolist(), strict=True))
    assert (within >= 0.84).all(), shown
    assert (within < 0.9).sum() <= 2, shown
    assert within.mean() <= 0.99, shown
    assert (stds.max(axis=0) <= LARGEST_STD).all(), stds.max(axis=0)


@pytest.fixture(scope="module")
def calibrated() -> tuple[CameraCalibration, Array]:
    truth = mounted(3, 20.0)
    return calibrate_camera(truth.recording, handwriting_pen()), truth.values


@pytest.mark.slow
def test_it_finds_what_is_wrong_with_a_pen(calibrated: tuple[CameraCalibration, Array]) -> None:
    result, truth = calibrated
    away = (result.whole.values - truth) / result.whole.std
    assert np.abs(away).max() < 4, away
    assert (np.abs(truth) > 4 * result.whole.std).sum() >= 4  # it is not nothing that is found
    assert all(score.other_half > score.before for score in result.scores)
    assert [score.rate_hz for score in result.scores] == pytest.approx([10.0, 5.0, 3.0])


@pytest.mark.slow
def test_its_pen_is_the_one_with_these_numbers(calibrated: tuple[CameraCalibration, Array]) -> None:
    result, _ = calibrated
    assert {p.key for p in result.values} <= {
        "level_rad",
        *(f"sensors.{s}.{k}" for s in ("accel", "gyro") for k in ("position_m", "sensor_to_body")),
    }
    # Stamps of capture are the recording's own: no delay explains them.
    assert result.pen.sensors["camera"].delay_s == handwriting_pen().sensors["camera"].delay_s
    assert any("the camera's stamps are" in sentence for sentence in result.sentences())
    by = {n.name: v for n, v in zip(result.numbers, result.fit.values, strict=True)}
    np.testing.assert_allclose(result.pen.level_rad, [by["level x"], by["level y"]])
    for name in ("accel", "gyro"):
        told, was = result.pen.sensors[name], handwriting_pen().sensors[name]
        turned = np.array(told.sensor_to_body) @ np.transpose(was.sensor_to_body)  # type: ignore[attr-defined]
        turn = Rotation.from_matrix(turned).as_rotvec()
        np.testing.assert_allclose(turn, [by[f"turn {a}"] for a in "xyz"], atol=1e-9)
        moved = np.subtract(told.position_m, was.position_m)  # type: ignore[attr-defined]
        np.testing.assert_allclose(moved, [by[f"lever {a}"] for a in "xyz"], atol=1e-12)


@pytest.fixture(scope="module")
def touching() -> pm.Recording:
    """Five seconds of handwriting, with a touch now and then that is not where the tip is."""
    drawn = pm.simulate(handwriting_pen(), SENSORS, motion="handwriting", duration_s=5.0, seed=1)
    parts = {name: drawn.sensor(name) for name in SENSORS}
    touch = parts["gyro"][0][::3]
    parts["contact"] = (touch, np.zeros((len(touch), 1)))
    return pm.Recording.from_sensors("touching", parts)


def frames_of(recording: pm.Recording, filtered: MountedFilter) -> Frames:
    """Return its frames, of a recording that is too short to calibrate by."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(frames, "SHORTEST_S", 0.0)
        return Frames.of(recording, filtered.base)


@pytest.mark.slow
def test_numbers_as_states_are_the_pen_file_with_them(touching: pm.Recording) -> None:
    """Frames are predicted alike: with numbers beside the file's, and with another file."""
    pen, rng = handwriting_pen(), np.random.default_rng(0)
    own = {
        TURN: 0.02 * rng.standard_normal(3),
        LEVER: 0.01 * rng.standard_normal(3),
        LEVEL: 0.02 * rng.standard_normal(2),
        SLOPE: 0.03 * rng.standard_normal(2),
    }
    with_numbers = MountedFilter(pen, WITH_CONTACT)
    with_file = MountedFilter(with_values(pen, new_values(pen, WITH_CONTACT, own)), WITH_CONTACT)
    [each, *_] = frames_of(touching, with_numbers).passes(0.0)
    at = (each.time_s, each.y, each.frames)
    told = with_numbers.told(np.concatenate([[0.0], *own.values(), [0.0]]), *at)
    expected = with_file.told(np.zeros(12), *at)
    np.testing.assert_allclose(told.log_density, expected.log_density, rtol=0, atol=1e-5)
    plain = with_numbers.told(np.zeros(12), *at)
    assert np.abs(told.log_density - plain.log_density).max() > 1.0
    # A plane that is higher is one that readings say is higher, and the file has no part in it.
    higher = np.where(np.isnan(each.y[:, 12:]), np.nan, 0.002)
    y = np.column_stack([each.y[:, :12], higher])
    moved = np.concatenate([np.zeros(11), [0.002]])
    np.testing.assert_allclose(
        with_numbers.told(moved, *at).log_density,
        with_numbers.told(np.zeros(12), each.time_s, y, each.frames).log_density,
        atol=1e-5,
    )
    assert with_numbers.numbers[-1].quantity is HEIGHT


def test_an_offset_is_a_shift_of_stamps(touching: pm.Recording) -> None:
    filtered, offset = MountedFilter(handwriting_pen(), SENSORS), 1e-3
    of = frames_of(touching, filtered)
    [as_stamped, *_], [shifted, *_] = (list(of.passes(by)) for by in (0.0, offset))
    assert filtered.numbers[0].quantity is OFFSET
    plain, by_number, by_stamps = (
        filtered.told(np.array([by, *np.zeros(8)]), each.time_s, each.y, each.frames)
        for by, each in ((0.0, as_stamped), (offset, as_stamped), (0.0, shifted))
    )
    # The density also changes by how sure predictions are over a longer time, the score does not.
    changes = [(told.score - plain.score).sum(axis=0) for told in (by_number, by_stamps)]
    assert changes[0][0] == pytest.approx(-offset * plain.information.sum(axis=0)[0, 0], rel=0.1)
    assert changes[1][0] == pytest.approx(changes[0][0], rel=0.1)


def test_one_run_tells_score_and_information(touching: pm.Recording) -> None:
    filtered = MountedFilter(handwriting_pen(), SENSORS)
    [each, *_] = frames_of(touching, filtered).passes(0.0)
    at = (each.time_s, each.y, each.frames)
    told = filtered.told(np.zeros(9), *at)
    score, information = told.score.sum(axis=0), told.information.sum(axis=0)
    for i, number in enumerate(filtered.numbers):
        step = np.zeros(9)
        step[i] = 1e-2 * number.quantity.plausible_std
        up, down = filtered.told(step, *at), filtered.told(-step, *at)
        change = (up.score - down.score).sum(axis=0) / (2 * step[i])
        scale = np.sqrt(np.diag(information) * information[i, i])
        np.testing.assert_allclose(-change / scale, information[i] / scale, atol=0.15)
        slope = (up.log_density - down.log_density).sum() / (2 * step[i])
        # The density also changes by how sure a prediction is, which the score leaves out.
        assert abs(slope - score[i]) < 0.05 * abs(score[i]) + 2 * np.sqrt(information[i, i])


def test_frames_before_their_stamps_are_a_longer_delay() -> None:
    """A reader stamps a frame with its arrival less the delay."""
    pen = pm.load_pen("dpoint")
    [(parameter, delay_s)] = new_values(pen, SENSORS, {OFFSET: np.array([-0.003])}).items()
    assert parameter.key == "sensors.camera.delay_s"
    assert delay_s == pytest.approx(pen.sensors["camera"].delay_s + 0.003)
    with pytest.raises(InputError, match=r"frames say that its delay is -2\.11 ms"):
        new_values(pen, SENSORS, {OFFSET: np.array([0.05])})


@pytest.mark.parametrize(
    ("sensors", "sentence"),
    [
        (["accel", "gyro"], "has no pose_camera, expected one to calibrate by"),
        (["accel", "camera"], "has no gyroscope of pen D-POINT stylus"),
        (["accel", "gyro", "kamera"], "did you mean camera"),
    ],
)
def test_what_is_missing_is_said(sensors: list[str], sentence: str) -> None:
    recording = pm.simulate("dpoint", SENSORS, duration_s=1.0)
    with pytest.raises(InputError, match=sentence):
        calibrate_camera(recording, "dpoint", sensors=sensors)


def test_a_short_recording_is_refused() -> None:
    recording = pm.simulate("dpoint", SENSORS, duration_s=2.5)
    with pytest.raises(
        InputError, match=r"has 15 frames in 0\.5 s after its first 2 s, expected at"
    ):
        calibrate_camera(recording, "dpoint")


def test_a_pen_that_does_not_move_tells_nothing() -> None:
    recording = pm.simulate("dpoint", SENSORS, motion="still", duration_s=19.0, seed=1)
    with pytest.raises(InputError, match="frames tell none of"):
        calibrate_camera(recording, handwriting_pen())
