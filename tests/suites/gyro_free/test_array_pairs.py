"""Pairs of a made-up array: axes, rest, segments."""

from __future__ import annotations

import numpy as np
import pytest

from classical_baseline.differential import differential_solution
from suites.gyro_free.array_pairs import FOLDER, PARTS, levelled, load_array, pair_segment
from suites.gyro_free.cases import ARRAY_CASES
from tests.recordings.array_recording import GRAVITY, ArrayTruth, write_array

PAIRS = sorted({pair for case in ARRAY_CASES.values() for pair in case.pairs})


@pytest.fixture(scope="module")
def made_up(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, ArrayTruth]:
    data = tmp_path_factory.mktemp("data")
    truth = write_array(data / FOLDER)
    return str(data), truth


def test_distances_are_those_of_the_board(made_up: tuple[str, ArrayTruth]) -> None:
    array = load_array(made_up[0])
    segment = PARTS["turns"](made_up[0])[0]
    for name, length in (("array edge", 18.9), ("array diagonal", 26.73)):
        for pair in ARRAY_CASES[name].pairs:
            assert 2e3 * pair_segment(array, segment, pair).half_distance_m == pytest.approx(
                length, abs=0.01
            )


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("part", PARTS)
def test_the_difference_is_the_rotation_in_the_axes_of_the_pair(
    made_up: tuple[str, ArrayTruth], part: str, pair: tuple[int, int]
) -> None:
    data, truth = made_up
    array = load_array(data)
    for segment in PARTS[part](data)[:3]:
        seen = pair_segment(array, segment, pair)
        along = array.position_m[pair[1]] - array.position_m[pair[0]]
        x = along / np.linalg.norm(along)
        axes = np.array([x, np.cross([0, 0, 1], x), [0, 0, 1]])
        assert np.linalg.det(axes) == pytest.approx(1)
        w = truth.rate[segment.samples] @ axes.T
        a = truth.rate_derivative[segment.samples] @ axes.T
        c = differential_solution(seen.f1, seen.f2, seen.half_distance_m)
        expected = np.column_stack(
            [
                -(w[:, 1] ** 2) - w[:, 2] ** 2,
                a[:, 2] + w[:, 0] * w[:, 1],
                -a[:, 1] + w[:, 0] * w[:, 2],
            ]
        )
        # Counts of 0.005 m/s² by the distance, and the calibration's open turn, see there.
        tolerance = 0.015 / (2 * seen.half_distance_m) + 0.02 * np.abs(expected).max()
        np.testing.assert_allclose(c, expected, atol=tolerance)
        assert np.abs(expected).max() > 3 * tolerance
        np.testing.assert_allclose(np.degrees(seen.rate - w), 0, atol=0.2)


def test_turns_begin_at_rest_and_know_how_they_stand(made_up: tuple[str, ArrayTruth]) -> None:
    data, truth = made_up
    array = load_array(data)
    for segment in PARTS["turns"](data):
        assert segment.rest is not None
        assert not truth.rate[segment.rest].any()
        seen = pair_segment(array, segment, PAIRS[0])
        assert not seen.start_rate.any()
        assert np.abs(seen.rate[0]).max() < np.radians(21)
        np.testing.assert_allclose(seen.C @ [0, 0, GRAVITY], seen.f1[0], atol=0.3)
        c = differential_solution(seen.f1, seen.f2, seen.half_distance_m)
        assert np.abs(c[0]).max() < 15


def test_what_begins_in_motion_is_told_its_first_rate_only(
    made_up: tuple[str, ArrayTruth],
) -> None:
    data, _ = made_up
    array = load_array(data)
    for part in ("between knocks", "shaken"):
        for segment in PARTS[part](data):
            seen = pair_segment(array, segment, PAIRS[0])
            np.testing.assert_array_equal(seen.start_rate, seen.rate[0])
            assert np.linalg.norm(seen.rate, axis=1).min() > np.radians(15)
            assert not array.clipped[segment.samples].any()


def test_levelling_is_right_side_up() -> None:
    for force in ([0.0, 0.0, 9.8], [3.0, -2.0, 8.0], [-9.0, 1.0, 1.0]):
        C = levelled(np.array(force))
        np.testing.assert_allclose(C @ C.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(C) == pytest.approx(1)
        np.testing.assert_allclose(C @ [0, 0, np.linalg.norm(force)], force, atol=1e-12)
        assert C[0, 1] == pytest.approx(0, abs=1e-12)  # the axis has azimuth zero
        assert C[0, 0] > 0
