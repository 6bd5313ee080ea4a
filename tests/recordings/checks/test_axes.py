"""Axes, levers and mountings are found where they are known exactly."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recordings.checks.axes_fit import CANDIDATES, fit_axes
from recordings.checks.axes_words import turned_axes, what_is_wrong
from recordings.checks.lever import lever_of
from recordings.checks.mountings import MOUNTINGS, axis_of, is_told, mounting_of, up_of
from recordings.checks.turns import gravity_turns
from tests.recordings.rods import turned_rod
from tests.recordings.swings import swinging


def test_every_way_of_axes_is_found_with_its_bias() -> None:
    t, rate, up = swinging(3)
    bias = np.radians([2.0, -3.0, 1.0])
    for k, P in enumerate(CANDIDATES):
        # ω = P ω_read + b: what is read is Pᵀ (ω - b).
        fit = fit_axes(gravity_turns(t, 9.81 * up, t, (rate - bias) @ P))
        assert fit.best == k
        assert fit.correlation[k] > 0.995
        assert fit.factor[k] == pytest.approx(1, abs=0.03)
        np.testing.assert_allclose(fit.bias[k], bias, atol=np.radians(0.6))


def test_a_flipped_sign_has_a_correlation_of_minus_one() -> None:
    t, rate, up = swinging(4, duration_s=40.0)
    fit = fit_axes(gravity_turns(t, up, t, -rate))
    assert fit.correlation[0] < -0.9
    assert fit.worse_by(0, fit.best) > 2


def test_the_lever_is_where_the_chip_is() -> None:
    for seed in range(3):
        rod = turned_rod(seed)
        still = rod.time_s < 0.9
        bias = rod.rate[still].mean(axis=0)
        lever = lever_of(rod.time_s, rod.force, rod.time_s, rod.rate - bias)
        assert lever is not None
        assert is_told(lever)
        off = np.abs(lever.arm_m - rod.mounting.T @ [0, 0, rod.place_m])
        assert (off < 0.01).all()
        assert (off < 6 * lever.std_m).all()


def test_a_tip_that_moves_tells_no_lever() -> None:
    rng, rod = np.random.default_rng(0), turned_rod(1)
    shaken = sum(
        np.outer(np.sin(2 * np.pi * f * rod.time_s + rng.uniform(0, 6)), rng.normal(0, 0.4, 3))
        for f in (0.9, 1.7, 2.6)
    )
    lever = lever_of(rod.time_s, rod.force + shaken, rod.time_s, rod.rate)
    assert not is_told(lever)


def test_a_mounting_takes_its_axis_to_the_pens() -> None:
    for M in MOUNTINGS:
        assert np.array_equal(mounting_of(M[2], M), M)
        found = mounting_of(M[2])
        np.testing.assert_array_equal(found @ M[2], [0, 0, 1])
        assert np.linalg.det(found) == pytest.approx(1)


def test_without_a_lever_the_most_upright_axis_is_guessed() -> None:
    up = up_of(np.tile([-7.9, -0.1, 5.5], (20, 1)))
    found = axis_of(up, None)
    assert found is not None
    assert not found.by_lever
    assert found.sure < 0.5
    np.testing.assert_array_equal(found.axis, [-1, 0, 0])
    assert axis_of(None, None) is None


def test_no_direction_without_gravity() -> None:
    rng = np.random.default_rng(1)
    assert up_of(rng.normal(0, 1, (500, 3))) is None


@pytest.mark.parametrize(
    ("matrix", "axes", "words"),
    [
        (-np.eye(3), ("-x", "-y", "-z"), "its sign is flipped, on all three axes"),
        (np.diag([1, -1, 1]), ("x", "-y", "z"), "the sign of y is flipped"),
        (np.eye(3)[[1, 0, 2]], ("y", "x", "z"), "axes x and y are swapped"),
        (np.eye(3)[[1, 2, 0]], ("y", "z", "x"), "its axes are shifted"),
    ],
)
def test_words(matrix: np.ndarray, axes: tuple[str, ...], words: str) -> None:
    assert turned_axes(matrix) == axes
    assert what_is_wrong(matrix) == words


def test_candidates_are_all_and_the_first_is_none() -> None:
    assert len({tuple(P.ravel()) for P in CANDIDATES}) == 48
    np.testing.assert_array_equal(CANDIDATES[0], np.eye(3))
    assert Rotation.from_matrix(MOUNTINGS).magnitude().min() == 0
