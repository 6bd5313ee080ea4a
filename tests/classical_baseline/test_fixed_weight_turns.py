"""One turn of fixed-weight fusion: both forms of its formula, the horizon, sums that cancel."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from classical_baseline.fixed_weight import (
    FixedWeightConfig,
    FixedWeightState,
    init,
    run,
    step,
    turn,
)
from tests.classical_baseline.carriers import FORMS, SIGNS, about_x, only_first
from tests.references.fixed_weight import turned_by_rotations

unit_angles = st.tuples(st.floats(-math.pi, math.pi), st.floats(-1.4, 1.4))
small_turns = st.floats(-0.3, 0.3)


def of_angles(angles: tuple[float, float]) -> tuple[float, float, float]:
    a, b = angles
    return math.cos(a) * math.cos(b), math.sin(a) * math.cos(b), math.sin(b)


@given(unit_angles, small_turns, small_turns)
def test_the_two_forms_agree_away_from_the_horizon(
    angles: tuple[float, float], turn_phi: float, turn_theta: float
) -> None:
    direction = of_angles(angles)
    x, y, z = direction
    turned = (math.atan2(x, z) + turn_phi, math.atan2(y, z) + turn_theta)
    if min(abs(math.cos(angle)) for angle in turned) < 0.02:
        return
    for sign in SIGNS:
        smooth = turn(direction, turn_phi, turn_theta, "smooth", sign)  # type: ignore[arg-type]
        tangents = turn(direction, turn_phi, turn_theta, "tangents", sign)  # type: ignore[arg-type]
        # The root of 1 - x² - y² turns rounding of 1e-16 into up to 1e-8.
        np.testing.assert_allclose(smooth, tangents, atol=1e-7)
        if abs(z) > 0.02:
            expected = turned_by_rotations(np.array(direction), (turn_theta, -turn_phi), sign)
            np.testing.assert_allclose(smooth, expected, atol=1e-7)


numbers = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e-13, 1e-300]),
)


@given(
    st.tuples(numbers, numbers, numbers),
    st.tuples(numbers, numbers, numbers),
    st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)),
    st.sampled_from([0.0, 0.25, 1.0, 300.0]),
    st.sampled_from(FORMS),
    st.sampled_from(SIGNS),
)
def test_it_always_says_a_unit_vector(
    first: tuple[float, float, float],
    second: tuple[float, float, float],
    rates: tuple[float, float],
    weight: float,
    form: str,
    sign: str,
) -> None:
    length = math.hypot(*first)
    if not 1e-12 <= length < math.inf:
        return
    state = init(first, (0.0, 0.0))
    config = FixedWeightConfig(weight, form, sign)  # type: ignore[arg-type]
    for _ in range(3):
        state = step(config, state, second, rates, 0.01)
        assert math.hypot(*state.direction) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("theta_deg", [90.0, 180.0, 270.0, -90.0])
def test_exactly_on_the_horizon_nothing_is_lost(form: str, theta_deg: float) -> None:
    theta = math.radians(theta_deg)
    for direction in ((0.0, round(math.sin(theta)), round(math.cos(theta))),
                      (round(math.sin(theta)), 0.0, round(math.cos(theta)))):  # fmt: skip
        stayed = turn(direction, 0.0, 0.0, form, "turned")  # type: ignore[arg-type]
        np.testing.assert_allclose(stayed, direction, atol=1e-7)


def test_with_tangents_rounding_on_the_horizon_turns_the_vector() -> None:
    # R_z is rounding, and so is R_y, but not their ratio: a turn makes both large.
    _, y, _ = turn((1.0, 1.2e-16, 1e-17), math.radians(1.5), 0.0, "tangents", "turned")
    assert abs(y) > 0.2, "the true one is still 0"
    assert turn((1.0, 0.0, 1e-17), math.radians(1.5), 0.0, "smooth", "turned")[1] == 0


def test_one_axis_that_is_not_level_does_not_converge() -> None:
    # About x alone, but leaning by 30 degrees: the ratio R_x : R_z changes, its rate is zero.
    def error_deg(n: int) -> float:
        time_s = np.linspace(0.0, 1.0, n + 1)
        lean, true = math.radians(30), about_x(time_s)
        true = np.column_stack([np.full(n + 1, math.sin(lean)), math.cos(lean) * true[:, 1:]])
        rates = np.column_stack([np.ones(n + 1), np.zeros(n + 1)])
        found = run(FixedWeightConfig(), time_s, only_first(true), rates)
        return math.degrees(math.acos(float(found[-1] @ true[-1])))

    assert error_deg(1000) == pytest.approx(error_deg(100), rel=0.01)
    # As the recursion has it: R_x / R_z as at the start, R_y / R_z turned. By hand.
    ratios = np.array([math.tan(math.radians(30)), math.tan(1.0), 1.0])
    true_end = np.array([0.5, math.cos(math.radians(30)) * math.sin(1.0), 0.0])
    true_end[2] = math.sqrt(1 - true_end @ true_end)
    by_hand = math.degrees(math.acos(float(ratios @ true_end / np.linalg.norm(ratios))))
    assert error_deg(100) == pytest.approx(by_hand, abs=1e-6)
    assert by_hand > 10


def test_where_the_two_angles_say_nothing_the_vector_stays() -> None:
    on_the_horizon = (0.6, 0.8, 0.0)
    assert turn(on_the_horizon, 0.0, 0.0, "smooth", "turned") == on_the_horizon
    # With tangents, whatever the two tangents have become of rounding: here, half and half.
    x, y, z = turn(on_the_horizon, 0.0, 0.0, "tangents", "turned")
    assert (x, y, z) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5), 0.0), abs=1e-7)


def test_a_radicand_below_zero_counts_as_zero() -> None:
    rng = np.random.default_rng(0)
    negative = 0
    for phi, theta in rng.uniform(-math.pi, math.pi, (20000, 2)):
        phi = math.pi / 2 + 1e-9 * phi
        gx = math.sin(phi) / math.sqrt(1 + (math.cos(phi) * math.tan(theta)) ** 2)
        gy = math.sin(theta) / math.sqrt(1 + (math.cos(theta) * math.tan(phi)) ** 2)
        if 1 - gx * gx - gy * gy < 0:
            negative += 1
            x, y, z = math.tan(phi), math.tan(theta), 1.0
            length = math.hypot(x, y, z)
            direction = (x / length, y / length, z / length)
            assert math.isfinite(turn(direction, 0.0, 0.0, "tangents", "turned")[2])
    assert negative > 100, "else nothing was tested"


def test_without_an_acceleration_the_gyroscope_goes_on() -> None:
    state = FixedWeightState((0.0, 0.0, 1.0), (0.2, 0.0))
    fallen = step(FixedWeightConfig(0.25), state, (0.0, 0.0, 0.0), (0.4, 0.0), 0.1)
    assert fallen.direction == pytest.approx((0.0, math.sin(0.03), math.cos(0.03)))
    assert fallen.rates == (0.4, 0.0)


def test_vectors_that_cancel_keep_the_gyroscope() -> None:
    state = FixedWeightState((0.0, 0.0, 1.0), (0.0, 0.0))
    kept = step(FixedWeightConfig(1.0), state, (0.0, 0.0, -9.81), (0.0, 0.0), 0.01)
    assert kept.direction == (0.0, 0.0, 1.0)
