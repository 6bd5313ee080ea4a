from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from classical_baseline.fixed_weight import (
    FixedWeightConfig,
    FixedWeightState,
    init,
    run,
    step,
    turn,
    weight_of_sum,
)
from models.arrays import Array
from models.errors import InputError
from tests.references.fixed_weight import fixed_weight_by_rotations, turned_by_rotations

FORMS = ("smooth", "tangents")
SIGNS = ("turned", "previous")


def about_x(theta: Array) -> Array:
    """What a resting accelerometer reads of a carrier turned about x, (n, 3)."""
    return np.column_stack([np.zeros_like(theta), np.sin(theta), np.cos(theta)])


def about_y(phi: Array) -> Array:
    return np.column_stack([np.sin(phi), np.zeros_like(phi), np.cos(phi)])


def only_first(acceleration: Array) -> Array:
    """Leave the rest to the gyroscope: without an acceleration what it says is kept."""
    return np.vstack([acceleration[:1], np.zeros_like(acceleration[1:])])


def noisy_turn(seed: int, n: int = 400) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    time_s = np.cumsum(rng.uniform(0.005, 0.015, n))
    theta = 2 * math.pi * (time_s - time_s[0]) / (time_s[-1] - time_s[0])
    acceleration = 9.81 * about_x(theta) + rng.normal(0, 0.3, (n, 3))
    rates = np.column_stack([np.gradient(theta, time_s), np.zeros(n)]) + rng.normal(0, 0.1, (n, 2))
    return time_s, acceleration, rates


@pytest.mark.parametrize("weight", [0.0, 0.25, 1.0, 20.0, 300.0])
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("sign", SIGNS)
@pytest.mark.parametrize("seed", [0, 1])
def test_it_is_the_reference(weight: float, form: str, sign: str, seed: int) -> None:
    samples = noisy_turn(seed)
    found = run(FixedWeightConfig(weight, form, sign), *samples)  # type: ignore[arg-type]
    expected = fixed_weight_by_rotations(weight, *samples, sign=sign)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_at_rest_it_says_what_the_accelerometer_says(form: str) -> None:
    resting = np.array([0.6, -0.48, 0.64])
    n = 50
    found = run(
        FixedWeightConfig(20.0, form),  # type: ignore[arg-type]
        np.arange(n) * 0.01,
        np.tile(9.81 * resting, (n, 1)),
        np.zeros((n, 2)),
    )
    np.testing.assert_allclose(found, np.tile(resting, (n, 1)), atol=1e-14)


def test_without_weight_it_is_the_accelerometer() -> None:
    time_s, acceleration, rates = noisy_turn(2)
    raw = acceleration / np.linalg.norm(acceleration, axis=1, keepdims=True)
    np.testing.assert_allclose(run(FixedWeightConfig(0.0), time_s, acceleration, rates), raw)


def test_a_large_weight_follows_the_gyroscope() -> None:
    time_s, acceleration, rates = noisy_turn(3)
    heavy = run(FixedWeightConfig(1e12), time_s, acceleration, rates)
    alone = run(FixedWeightConfig(), time_s, only_first(acceleration), rates)
    np.testing.assert_allclose(heavy, alone, atol=1e-8)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("reads", "column", "factor"), [(about_x, 0, 1.0), (about_y, 1, -1.0)])
def test_a_constant_rate_is_integrated_exactly(
    form: str, reads: object, column: int, factor: float
) -> None:
    # All the way round, three times; samples of the second lie on 90, 180 and 270 degrees.
    for n in (731, 720) if form == "smooth" else (731,):
        angle = np.linspace(0, 6 * math.pi, n + 1)
        time_s = 0.01 * np.arange(n + 1)
        rates = np.zeros((n + 1, 2))
        rates[:, column] = factor * (angle[1] - angle[0]) / 0.01
        true = reads(angle)  # type: ignore[operator]
        found = run(FixedWeightConfig(form=form), time_s, only_first(true), rates)  # type: ignore[arg-type]
        np.testing.assert_allclose(found, true, atol=1e-7)


@pytest.mark.parametrize("weight", [0.25, 50.0])
def test_the_sign_of_the_previous_z_is_late(weight: float) -> None:
    theta = np.radians(np.arange(60.3, 130.0, 0.5))
    time_s, true = 0.01 * np.arange(len(theta)), about_x(theta)
    rates = np.tile([math.radians(50.0), 0.0], (len(theta), 1))

    def error_deg(sign: str) -> float:
        found = run(FixedWeightConfig(weight, sign=sign), time_s, true, rates)  # type: ignore[arg-type]
        return float(np.degrees(np.arccos(np.clip((found * true).sum(axis=1), -1, 1))).max())

    assert error_deg("turned") < 1e-5
    # Turned back by up to what was turned forth, and with a large weight again and again.
    assert 0.05 < error_deg("previous") < 0.5 if weight < 1 else error_deg("previous") > 5


def test_trapezoidal_rates_are_of_second_order() -> None:
    def error(n: int) -> float:
        time_s = np.linspace(0.0, 3.0, n + 1)
        theta = 1.5 * np.sin(1.3 * time_s) + 0.4 * time_s**2
        rates = np.column_stack([1.95 * np.cos(1.3 * time_s) + 0.8 * time_s, np.zeros(n + 1)])
        true = about_x(theta)
        found = run(FixedWeightConfig(), time_s, only_first(true), rates)
        return float(np.linalg.norm(found[-1] - true[-1]))

    errors = np.array([error(n) for n in (50, 100, 200, 400)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.02)


def test_turns_about_two_axes_do_not_converge() -> None:
    def rate(t: Array | float) -> Array:
        return np.array([np.cos(2 * t), np.sin(2 * t), 0 * np.asarray(t)])

    def error_deg(n: int) -> float:
        time_s = np.linspace(0.0, 3.0, n + 1)
        true = solve_ivp(
            lambda t, R: -np.cross(rate(t), R), (0, 3), [0.0, 0.0, 1.0],
            t_eval=time_s, rtol=1e-10, atol=1e-12,
        ).y.T  # fmt: skip
        assert true[:, 2].min() > 0.2, "away from the horizon, where there are other errors"
        found = run(FixedWeightConfig(), time_s, only_first(true), rate(time_s)[:2].T)
        return math.degrees(math.acos(float(found[-1] @ true[-1])))

    errors = np.array([error_deg(n) for n in (100, 1000, 10000)])
    assert errors.min() > 5, "the drift remains however small the step is"
    assert abs(errors[2] - errors[1]) < 0.001 * errors[2], "and is a limit of its own"


def test_turns_about_z_are_not_seen() -> None:
    n = 101
    yaw = np.linspace(0, math.pi / 2, n)
    lean = math.radians(30)
    true = np.column_stack(
        [math.sin(lean) * np.cos(yaw), math.sin(lean) * -np.sin(yaw), np.full(n, math.cos(lean))]
    )
    found = run(FixedWeightConfig(), 0.01 * np.arange(n), only_first(true), np.zeros((n, 2)))
    np.testing.assert_allclose(found[-1], true[0], atol=1e-12)


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


@pytest.mark.parametrize("convex", [0.0, 0.25, 0.9, 0.999])
def test_a_convex_sum_is_a_sum_with_another_weight(convex: float) -> None:
    measured, turned = np.array([0.6, 0.0, 0.8]), np.array([0.0, 0.6, 0.8])
    wanted = (1 - convex) * measured + convex * turned
    state = FixedWeightState((0.0, 0.6, 0.8), (0.0, 0.0))
    config = FixedWeightConfig(weight_of_sum(convex))
    found = step(config, state, (0.6, 0.0, 0.8), (0.0, 0.0), 0.1).direction
    np.testing.assert_allclose(found, wanted / np.linalg.norm(wanted), atol=1e-12)


def test_a_convex_weight_of_one_is_the_gyroscope_alone() -> None:
    config = FixedWeightConfig(weight_of_sum(1.0))
    state = FixedWeightState((0.0, 0.6, 0.8), (0.0, 0.0))
    found = step(config, state, (0.6, 0.0, 0.8), (0.0, 0.0), 0.1).direction
    np.testing.assert_allclose(found, (0.0, 0.6, 0.8), atol=1e-12)


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


def test_steps_are_the_run_and_leave_their_state() -> None:
    time_s, acceleration, rates = noisy_turn(4, 30)
    config = FixedWeightConfig(3.0)
    state = start = init(tuple(acceleration[0]), tuple(rates[0]))
    for k in range(1, 30):
        step_s = float(time_s[k] - time_s[k - 1])
        state = step(config, state, tuple(acceleration[k]), tuple(rates[k]), step_s)
    assert start == init(tuple(acceleration[0]), tuple(rates[0]))
    np.testing.assert_array_equal(state.direction, run(config, time_s, acceleration, rates)[-1])


@pytest.mark.parametrize("weight", [-0.1, math.nan, math.inf])
def test_bad_weights(weight: float) -> None:
    with pytest.raises(InputError, match="expected a number from 0 on"):
        FixedWeightConfig(weight)


def test_bad_forms() -> None:
    with pytest.raises(InputError, match="form is round, expected one of smooth, tangents"):
        FixedWeightConfig(form="round")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="sign is next"):
        FixedWeightConfig(sign="next")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, a, r: (t, a[:, :2], r), r"accelerations have shape \(5, 2\), expected \(5, 3\)"),
        (lambda t, a, r: (t, a, r[:4]), r"rates have shape \(4, 2\), expected \(5, 2\)"),
        (lambda t, a, r: (t[::-1], a, r), "times of the samples do not increase"),
        (lambda t, a, r: (t, np.where(np.arange(5)[:, None] == 3, np.nan, a), r),
         "accelerations of sample 3 are not finite"),
        (lambda t, a, r: (t, a, r * np.inf), "rates of sample 0 are not finite"),
        (lambda t, a, r: (t, 0 * a, r), "the first acceleration is zero"),
        (lambda t, a, r: (t[:0], a[:0], r[:0]), "there are no samples"),
    ],
)  # fmt: skip
def test_bad_samples(change: object, message: str) -> None:
    samples = noisy_turn(0, 5)
    with pytest.raises(InputError, match=message):
        run(FixedWeightConfig(), *change(*samples))  # type: ignore[operator]
