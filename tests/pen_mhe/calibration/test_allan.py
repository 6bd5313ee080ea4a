"""Noise levels by Allan variance: against the textbook's formula, and against what was drawn."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from pen_mhe.calibration import still
from pen_mhe.calibration.allan import (
    FIRST_S,
    LIBRARY,
    NoiseLevels,
    allan_curve,
    has_library,
    noise_levels,
)
from pen_mhe.calibration.still import calibrate_still
from tests.pen_mhe.calibration.poses import FORCE_STD, STEP_S, Array, board, board_pen
from tests.references.allan import allan_variance

needs_library = pytest.mark.skipif(
    importlib.util.find_spec(LIBRARY) is None, reason=f"{LIBRARY} is not installed: extra calibrate"
)
RATE_HZ, STD = 100.0, 0.01
N = STD / np.sqrt(RATE_HZ)


def drawn(seed: int, n: int, walk: float = 0.0) -> Array:
    rng = np.random.default_rng(seed)
    steps = walk / np.sqrt(RATE_HZ) * rng.standard_normal((n, 3))
    return np.asarray(STD * rng.standard_normal((n, 3)) + np.cumsum(steps, axis=0))


def levels(stretches: list[Array]) -> NoiseLevels:
    curve = allan_curve(stretches, RATE_HZ)
    assert curve is not None
    found = noise_levels(curve)
    assert found is not None
    return found


@needs_library
def test_the_curve_of_one_stretch_is_the_textbooks() -> None:
    values = drawn(0, 3000) + 5.0
    curve = allan_curve([values], RATE_HZ)
    assert curve is not None
    clusters = np.round(curve.tau_s * RATE_HZ).astype(int)
    assert clusters[0] == FIRST_S * RATE_HZ
    expected = [np.mean([allan_variance(axis, m) for axis in values.T]) for m in clusters]
    # The library leaves out the last of about 3000 differences.
    np.testing.assert_allclose(curve.variance, expected, rtol=5e-3)


@needs_library
@pytest.mark.parametrize(
    "runs", [pytest.param(50, marks=pytest.mark.slow, id="50 runs"), pytest.param(8, id="8 runs")]
)
def test_white_noise_is_found_as_well_as_it_says(runs: int) -> None:
    found = [levels([drawn(100 * s + i, 250) for i in range(20)]) for s in range(runs)]
    away = np.array([(one.density[0] - N) / one.density[1] for one in found])
    assert np.mean(np.abs(away) <= 2) >= 0.9
    assert np.mean([one.density[1] for one in found]) < 0.02 * N
    # Two and a half seconds show no more, and it does not claim so.
    assert all(one.instability is None for one in found)
    assert all(one.walk is None for one in found)


@needs_library
def test_a_walk_is_found_where_a_stretch_is_long_enough() -> None:
    found = [levels([drawn(s, 40_000, walk=2e-4)]) for s in range(6)]
    walks = [one.walk for one in found if one.walk is not None]
    assert len(walks) >= 5
    away = np.array([(value - 2e-4) / std for value, std in walks])
    assert np.abs(away).max() < 4
    assert np.median([value for value, _ in walks]) == pytest.approx(2e-4, rel=0.25)


@needs_library
def test_too_short_or_constant_readings_say_nothing() -> None:
    assert allan_curve([drawn(0, 7)], RATE_HZ) is None
    curve = allan_curve([np.ones((300, 3))], RATE_HZ)
    assert curve is not None
    assert noise_levels(curve) is None


@needs_library
def test_the_pen_file_is_told_the_noise_of_a_sample() -> None:
    """The file's density is twice what was drawn; its bandwidth makes σ √STEP_S of samples σ."""
    found = calibrate_still(board(1).recording, board_pen())
    value, std = found.sensors["accel"].density or (0.0, 0.0)
    expected = FORCE_STD * np.sqrt(STEP_S)
    assert 0 < abs(value - expected) < 3 * std < 0.1 * expected
    accel = found.pen.sensors["accel"]
    assert accel.sample_std == pytest.approx(FORCE_STD, rel=0.05)  # type: ignore[attr-defined]
    assert any(
        "instability and walk are not determined" in sentence for sentence in found.sentences()
    )
    # Beside a resolution the noise that is drawn is the rest.
    step = FORCE_STD
    coarse = calibrate_still(board(1).recording, board_pen(resolution_m_s2=step))
    told = coarse.pen.sensors["accel"]
    assert told.sample_std == pytest.approx(FORCE_STD, rel=0.05)  # type: ignore[attr-defined]
    assert told.noise_density_m_s2_per_sqrt_hz < 0.97 * value  # type: ignore[attr-defined]


@needs_library
def test_noise_alone_needs_one_pose(monkeypatch: pytest.MonkeyPatch) -> None:
    one = board(2, np.array([[0.0, 0.0, 1.0]]), rest_s=5.0).recording
    found = calibrate_still(one, board_pen(), find="noise")
    assert {number.quantity for number in found.numbers} == {"noise density"}
    monkeypatch.setattr(still, "has_library", lambda: False)
    assert calibrate_still(one, board_pen(), find="noise").numbers == ()


def test_without_the_library_noise_stays_and_it_says_what_is_needed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(still, "has_library", lambda: False)
    found = calibrate_still(board(1).recording, board_pen())
    fields = {parameter.field for parameter in found.values}
    assert fields == {"bias_m_s2", "sensitivity", "bias_std_m_s2", "bias_rad_s", "bias_std_rad_s"}
    assert "they need pip install 'pen-mhe[calibrate]'" in found.sentences()[-1]
    assert has_library() is (importlib.util.find_spec(LIBRARY) is not None)
