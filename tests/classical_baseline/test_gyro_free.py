"""Integrated and compensated rates against exact cases and independent solutions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from classical_baseline.differential import differential_solution
from classical_baseline.differentiators import DIFFERENTIATORS
from classical_baseline.gyro_free import Compensation, integrate_rate, rate_error
from models.errors import InputError
from tests.classical_baseline.gestures import HALF_DISTANCE_M, circling, gesture, order
from tests.references import gyro_free as reference

BOLD = Compensation(least_determinant=1e-9, greatest_condition=1e9)


def test_at_rest_the_rate_is_zero_and_nothing_is_compensated() -> None:
    found = integrate_rate(np.zeros((100, 3)), 0.005, compensation=BOLD)
    assert not found.rate.any()
    assert not found.compensated.any()


@pytest.mark.parametrize("compensation", [None, BOLD])
def test_a_constant_rate_stays(compensation: Compensation | None) -> None:
    wy, wz = 0.7, -1.1
    c = np.tile([-(wy**2 + wz**2), 0.0, 0.0], (60, 1))
    found = integrate_rate(c, 0.01, (wy, wz), compensation)
    np.testing.assert_array_equal(found.rate, np.tile([0.0, wy, wz], (60, 1)))
    assert not found.compensated.any()


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)])
def test_about_one_axis_the_matrix_is_singular_and_the_integral_stands(
    direction: tuple[float, float],
) -> None:
    t = np.arange(200) * 0.01
    rate, derivative = 2 * np.sin(3 * t), 6 * np.cos(3 * t)
    c = np.column_stack([-(rate**2), derivative * direction[1], -derivative * direction[0]])
    plain, compensated = (
        integrate_rate(c, 0.01, (0.0, 0.0), how) for how in (None, Compensation())
    )
    np.testing.assert_allclose(compensated.rate, plain.rate, atol=1e-13)
    assert not np.isnan(compensated.rate).any()
    # The trapezoidal rule gives a sine exactly, but for this factor.
    expected = np.outer(rate, [0.0, *direction]) * 0.015 / np.tan(0.015)
    np.testing.assert_allclose(plain.rate, expected, atol=1e-12)


def test_the_integration_is_of_second_order() -> None:
    errors = []
    for step in (0.02, 0.01, 0.005):
        motion = gesture(step)
        c = differential_solution(motion.f1, motion.f2, HALF_DISTANCE_M)
        c[0] = 0.0  # at rest; the second difference does not reach before the start
        errors.append(float(np.abs(integrate_rate(c, step).rate - motion.rate).max()))
    np.testing.assert_allclose(order(errors), 2.0, atol=0.1)


def test_compensated_it_still_is_of_second_order() -> None:
    errors = []
    for step in (0.01, 0.005, 0.0025):
        t = np.arange(0, 2 + step / 2, step)
        size, turn = 1 + 0.3 * np.sin(2 * t), 5.0
        wy, wz = size * np.cos(turn * t), size * np.sin(turn * t)
        size_dot = 0.6 * np.cos(2 * t)
        wy_dot = size_dot * np.cos(turn * t) - turn * wz
        wz_dot = size_dot * np.sin(turn * t) + turn * wy
        c = np.column_stack([-(size**2), wz_dot, -wy_dot])
        found = integrate_rate(c, step, (1.0, 0.0), Compensation())
        assert found.compensated.mean() > 0.8
        settled = t > 0.5
        error = found.rate[settled, 1:] - np.column_stack([wy, wz])[settled]
        errors.append(float(np.abs(error).max()))
    np.testing.assert_allclose(order(errors), 2.0, atol=0.25)


@pytest.mark.parametrize(
    "how",
    [
        Compensation(),
        Compensation(gain=0.3),
        replace(Compensation(), least_determinant=0.1, gain=0.5),
    ],
)
def test_it_is_the_two_by_two_system_solved_sample_by_sample(how: Compensation) -> None:
    motion, rng = gesture(0.005), np.random.default_rng(2)
    c = differential_solution(motion.f1, motion.f2, HALF_DISTANCE_M)
    c += 0.05 + 1e-3 * rng.standard_normal(c.shape)
    found = integrate_rate(c, 0.005, (0.1, -0.2), how)
    expected, applied = reference.compensated_rate(
        c,
        how.differentiator(c[:, 0], 0.005),
        0.005,
        (0.1, -0.2),
        how.least_determinant,
        how.greatest_condition,
        how.gain,
    )
    np.testing.assert_array_equal(found.compensated, applied)
    assert 0.1 < applied.mean() < 1
    np.testing.assert_allclose(found.rate[:, 1:], expected, rtol=1e-7, atol=1e-7)


def test_a_wrong_rate_is_corrected_to_second_order() -> None:
    rate, c = circling(0.01)
    left = []
    for size in (0.08, 0.04, 0.02):
        wrong = rate[30, 1:] + size * np.array([0.6, 0.8])
        error = rate_error(wrong[0], wrong[1], tuple(c[30]), 0.0, Compensation())
        assert error is not None
        left.append(float(np.linalg.norm(wrong - error - rate[30, 1:])))
    np.testing.assert_allclose(order(left), 2.0, atol=0.1)
    assert left[-1] < 0.02**2


def test_a_wrong_start_is_forgotten_inside_the_integration() -> None:
    rate, c = circling(0.001)
    start = (rate[0, 1] + 0.05, rate[0, 2] - 0.05)
    plain = integrate_rate(c, 0.001, start).rate - rate
    compensated = integrate_rate(c, 0.001, start, Compensation())
    assert np.abs(plain[-1]).max() == pytest.approx(0.05, rel=1e-3)
    assert compensated.compensated[14:].all()
    assert not compensated.compensated[:14].any()  # the derivative needs 15 samples
    # Each sample's correction is exact to second order: after a few there is nothing left.
    assert np.abs(compensated.rate - rate)[20:].max() < 1e-6


def test_a_constant_bias_of_the_derivative_is_held_down() -> None:
    rate, c = circling(0.005, 2.0)
    biased = c + np.array([0.0, 0.01, -0.01])
    plain, compensated = (
        np.abs(integrate_rate(biased, 0.005, (rate[0, 1], rate[0, 2]), how).rate - rate)[-1].max()
        for how in (None, Compensation())
    )
    assert plain == pytest.approx(0.02, rel=0.01)
    assert compensated < plain / 5


@pytest.mark.parametrize("field", ["least_determinant", "greatest_condition"])
def test_thresholds_keep_the_compensation_out(field: str) -> None:
    _, c = circling(0.005)
    how = replace(Compensation(), **{field: 1e6 if field == "least_determinant" else 1.0})
    assert not integrate_rate(c, 0.005, (1.5, 0.0), how).compensated.any()
    assert integrate_rate(c, 0.005, (1.5, 0.0), Compensation()).compensated.any()


def test_the_condition_is_that_of_the_matrix() -> None:
    rng = np.random.default_rng(7)
    for _ in range(50):
        wy, wz, cy, cz = rng.standard_normal(4)
        condition = np.linalg.cond([[2 * wy, 2 * wz], [cz, -cy]])
        for factor, applies in ((1.001, True), (0.999, False)):
            how = Compensation(
                least_determinant=1e-12, greatest_condition=max(1.0, factor * condition)
            )
            found = rate_error(wy, wz, (-1.0, cy, cz), 0.0, how)
            assert (found is not None) == applies


def test_the_sign_is_that_of_the_start() -> None:
    """ω and -ω have the same c_X, and the opposite ω̇: a rate that is integrated has a sign."""
    rate, c = circling(0.002)
    mirrored = c * [1.0, -1.0, -1.0]
    found = integrate_rate(mirrored, 0.002, (-rate[0, 1], -rate[0, 2]), Compensation())
    np.testing.assert_allclose(found.rate, -rate, atol=1e-4)


def test_missing_samples_are_not_hidden() -> None:
    _, c = circling(0.01)
    c[50] = np.nan
    for how in (None, Compensation()):
        rate = integrate_rate(c, 0.01, (1.5, 0.0), how).rate
        assert np.isfinite(rate[:50]).all()
        assert np.isnan(rate[50:, 1:]).all()


def test_edges_and_bad_input() -> None:
    for how in (None, Compensation()):
        assert integrate_rate(np.zeros((0, 3)), 0.01, compensation=how).rate.shape == (0, 3)
        one = integrate_rate(np.ones((1, 3)), 0.01, (0.1, 0.2), how)
        np.testing.assert_array_equal(one.rate, [[0.0, 0.1, 0.2]])
    with pytest.raises(InputError, match=r"shape \(4, 2\), expected \(n, 3\)"):
        integrate_rate(np.zeros((4, 2)), 0.01)
    for step in (0.0, np.nan, np.inf):
        with pytest.raises(InputError, match="expected a positive time"):
            integrate_rate(np.zeros((4, 3)), step)
    for field, value in (
        ("least_determinant", 0.0),
        ("least_determinant", np.nan),
        ("greatest_condition", 0.5),
        ("gain", 0.0),
        ("gain", 1.5),
    ):
        with pytest.raises(InputError, match=field):
            replace(Compensation(), **{field: value})
    assert Compensation().differentiator is DIFFERENTIATORS["savitzky-golay"]
