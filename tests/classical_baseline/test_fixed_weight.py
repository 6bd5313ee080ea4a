"""Fusion with a fixed weight: runs against a reference, exact cases, weights, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from classical_baseline.fixed_weight import (
    FixedWeightConfig,
    FixedWeightState,
    init,
    run,
    step,
    weight_of_sum,
)
from models.arrays import Array
from models.errors import InputError
from tests.classical_baseline.carriers import FORMS, SIGNS, about_x, about_y, noisy_turn, only_first
from tests.references.fixed_weight import fixed_weight_by_rotations


@pytest.mark.cover
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
