"""The array's loader: what was made wrong is put right, on the still poses alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from models.errors import InputError
from recordings.formats.imu_array import (
    FILE,
    affine_calibration,
    calibrated,
    read_imu_array,
    still_poses,
)
from tests.recordings.array_recording import GRAVITY, POSES, POSITIONS, write_array

COUNT_M_S2 = 9.80665 / 2048


def test_axes_and_units_of_both_sides(tmp_path: Path) -> None:
    truth = write_array(tmp_path)
    array = read_imu_array(tmp_path)
    expected = np.einsum("iab,nib->nia", truth.matrices, truth.force) + truth.biases
    fine = ~array.clipped
    np.testing.assert_allclose(array.force[fine], expected[fine], atol=COUNT_M_S2)
    away = np.degrees(array.rate - truth.rate[:, None])
    assert np.abs(away[fine]).max() < 5  # biases of some degrees per second
    np.testing.assert_array_equal(array.position_m, POSITIONS)
    np.testing.assert_array_equal(array.time_s, truth.time_s)


def test_still_poses_are_all_found_and_nothing_moves_in_them(tmp_path: Path) -> None:
    truth = write_array(tmp_path)
    poses = still_poses(read_imu_array(tmp_path))
    assert len(poses) == POSES + 1
    for pose in poses:
        assert np.abs(truth.rate[pose]).max() < np.radians(3)
        assert truth.time_s[pose.stop - 1] - truth.time_s[pose.start] > 1.0


def test_calibration_finds_the_forces_of_the_moving_board_too(tmp_path: Path) -> None:
    truth = write_array(tmp_path)
    array = calibrated(read_imu_array(tmp_path), GRAVITY)
    # One rotation of all of it is open; take it from the rest.
    rest = np.concatenate([np.arange(pose.start, pose.stop) for pose in still_poses(array)])
    true, found = (force[rest].mean(axis=1) for force in (truth.force, array.force))
    left, _, right = np.linalg.svd(true.T @ found)
    turn = left @ right
    assert np.degrees(np.arccos((np.trace(turn) - 1) / 2)) < 2  # the mean sensor's
    fine = ~array.clipped.any(axis=1)
    assert fine.sum() > 1000
    error = np.linalg.norm(array.force[fine] - truth.force[fine] @ turn, axis=2)
    size = np.linalg.norm(truth.force[fine], axis=2)
    assert np.abs(truth.force[fine] - GRAVITY).max() > 5  # it is moved hard
    assert (error < 0.002 * size + COUNT_M_S2).all()


def test_gyroscopes_lose_their_bias_and_the_clipped_ones_their_say(tmp_path: Path) -> None:
    truth = write_array(tmp_path)
    array = calibrated(read_imu_array(tmp_path), GRAVITY)
    slow = np.linalg.norm(truth.rate, axis=1) < np.radians(1500)
    assert np.degrees(np.abs(array.mean_rate - truth.rate)[slow]).max() < 0.2
    one = array.clipped.copy()
    one[100] = [True] * 7 + [False]
    one[101] = True
    mean = type(array)(array.time_s, array.force, array.rate, array.position_m, one).mean_rate
    np.testing.assert_array_equal(mean[100], array.rate[100, 7])
    assert np.isnan(mean[101]).all()


def test_perfect_sensors_are_left_as_they_are() -> None:
    u = np.random.default_rng(1).standard_normal((20, 1, 3))
    means = np.repeat(GRAVITY * u / np.linalg.norm(u, axis=2, keepdims=True), 4, axis=1)
    M, b = affine_calibration(means, GRAVITY)
    np.testing.assert_allclose(M, np.tile(np.eye(3), (4, 1, 1)), atol=1e-9)
    np.testing.assert_allclose(b, 0, atol=1e-8)


def test_a_clipped_sample_is_marked(tmp_path: Path) -> None:
    write_array(tmp_path)
    with np.load(tmp_path / FILE) as file:
        arrays = dict(file)
    arrays["acc"][5, 2, 1] = -32768
    arrays["gyr"][7, 4, 0] = 32767
    np.savez(tmp_path / FILE, **arrays)
    clipped = read_imu_array(tmp_path).clipped
    assert clipped[5].tolist() == [i == 2 for i in range(8)]
    assert clipped[7].tolist() == [i == 4 for i in range(8)]
    assert not clipped[6].any()


def test_bad_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"exp_1_raw_int16\.npz: No such file"):
        read_imu_array(tmp_path)
    (tmp_path / FILE).write_text("no archive")
    with pytest.raises(InputError, match="expected a NumPy"):
        read_imu_array(tmp_path)
    np.savez(tmp_path / FILE, t=np.zeros(3), acc=np.zeros((3, 8, 3)), pos_m=np.zeros((8, 3)))
    with pytest.raises(InputError, match="key gyr: expected 3 dimensions"):
        read_imu_array(tmp_path)
    np.savez(
        tmp_path / FILE,
        t=np.zeros(3),
        acc=np.zeros((3, 8, 3)),
        gyr=np.zeros((2, 8, 3)),
        pos_m=np.zeros((8, 3)),
    )
    with pytest.raises(InputError, match=r"expected \(3, 8, 3\)"):
        read_imu_array(tmp_path)


def test_too_few_poses_are_refused(tmp_path: Path) -> None:
    write_array(tmp_path)
    with np.load(tmp_path / FILE) as file:
        arrays = {key: values if key == "pos_m" else values[:300] for key, values in file.items()}
    np.savez(tmp_path / FILE, **arrays)
    with pytest.raises(InputError, match="expected at least 8 to calibrate on"):
        calibrated(read_imu_array(tmp_path), GRAVITY)


def test_the_real_array(data_folder: Path) -> None:
    folder = data_folder / "isa_imu_array"
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent")
    raw = read_imu_array(folder)
    poses = still_poses(raw)
    assert len(poses) >= 20
    array = calibrated(raw, GRAVITY)
    before, after = (np.array([a.force[pose].mean(axis=0) for pose in poses]) for a in (raw, array))
    # Their length is gravity, and all sensors agree on it.
    errors = [np.abs(np.linalg.norm(means, axis=2) - GRAVITY).max() for means in (before, after)]
    assert errors[0] > 0.1
    assert errors[1] < 0.02
    assert np.abs(after - after.mean(axis=1, keepdims=True)).max() < 0.03
