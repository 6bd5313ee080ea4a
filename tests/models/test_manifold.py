"""Moving a state and taking the difference of two: angles go the short way round."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from models.manifold import additive_manifold
from models.pen import pen_model
from models.sensor_kinds.accelerometer import Accelerometer
from tests.models.pens import ACCELEROMETER, Array, call, pen

SENSORS = {"accel": Accelerometer(**ACCELEROMETER, bias_std_m_s2=0.3)}
MODEL = {n: pen_model(pen(n, SENSORS)) for n in (5, 6)}
DEGREES_OF_FREEDOM = st.sampled_from([5, 6])

# |a + b| up to 2π is rounded to 1e-15 before it is wrapped.
ROUNDING = 4e-15


def angles_of(n: int) -> slice:
    return slice(3, n)


@st.composite
def states_and_moves(draw: st.DrawFn) -> tuple[int, Array, Array]:
    """Draw a state and a tangent vector whose angles are shorter than half a turn."""
    n = draw(DEGREES_OF_FREEDOM)
    n_x = MODEL[n].n_x

    def vector(limit: float) -> Array:
        numbers = st.floats(-limit, limit)
        return np.array(draw(st.lists(numbers, min_size=n_x, max_size=n_x)))

    return n, vector(np.pi), vector(3.14)


@given(states_and_moves())
def test_difference_undoes_retract(drawn: tuple[int, Array, Array]) -> None:
    n, x, delta = drawn
    moved = call(MODEL[n].retract, x, delta)
    assert call(MODEL[n].difference, moved, x) == pytest.approx(delta, abs=ROUNDING)


@given(states_and_moves())
def test_retract_undoes_difference(drawn: tuple[int, Array, Array]) -> None:
    """On the circle: the same attitude, not always the same number."""
    n, x, delta = drawn
    target = x + delta
    back = call(MODEL[n].retract, x, call(MODEL[n].difference, target, x))
    turns = (back - target)[angles_of(n)]
    assert np.cos(turns) == pytest.approx(np.ones(n - 3), abs=1e-15)
    assert np.sin(turns) == pytest.approx(np.zeros(n - 3), abs=ROUNDING)
    assert np.delete(back - target, angles_of(n)) == pytest.approx(0, abs=ROUNDING)


@given(states_and_moves(), st.integers(-3, 3))
def test_only_angles_are_wrapped(drawn: tuple[int, Array, Array], turns: int) -> None:
    """Whole turns of an angle change nothing; rates, positions and biases just add."""
    n, x, delta = drawn
    angles = angles_of(n)
    wound = x.copy()
    wound[angles] += 2 * np.pi * turns
    moved = call(MODEL[n].retract, wound, delta)
    assert np.abs(moved[angles]).max() <= np.pi + ROUNDING
    assert np.array_equal(np.delete(moved, angles), np.delete(x + delta, angles))
    difference = call(MODEL[n].difference, wound, x)
    assert difference == pytest.approx(np.zeros(len(x)), abs=2e-14)
    far = call(MODEL[n].difference, 10 * x, -10 * x)
    assert np.array_equal(np.delete(far, angles), np.delete(20 * x, angles))


@pytest.mark.parametrize(
    ("n", "angle"),
    [(5, "azimuth"), (5, "elevation"), (6, "azimuth"), (6, "elevation"), (6, "spin")],
)
def test_across_the_seam(n: int, angle: str) -> None:
    """From 179° forward by 4° is -177°, and the way from there back is -4°."""
    model = MODEL[n]
    at = model.state_names.index(f"{angle}_rad")
    x, delta = np.zeros(model.n_x), np.zeros(model.n_x)
    x[at], delta[at] = np.deg2rad(179), np.deg2rad(4)
    moved = call(model.retract, x, delta)
    assert moved[at] == pytest.approx(np.deg2rad(-177), abs=ROUNDING)
    assert call(model.difference, x, moved)[at] == pytest.approx(-delta[at], abs=ROUNDING)
    assert call(model.difference, moved, x)[at] == pytest.approx(delta[at], abs=ROUNDING)


@given(st.floats(-1e4, 1e4))
@example(np.pi)
@example(np.nextafter(np.pi, 4))
@example(-np.pi)
@example(0.0)
def test_an_angle_is_what_it_was_less_whole_turns(angle: float) -> None:
    """Not moved, and within a turn, it is the same to the last bit."""
    retract, _ = additive_manifold([True])
    wrapped = float(call(retract, [angle], [0.0])[0])
    rounding = 4e-16 * max(abs(angle), 10)
    assert abs(wrapped) <= np.pi + rounding
    assert abs(math.remainder(wrapped - angle, 2 * math.pi)) <= rounding
    if -np.pi < angle <= np.pi:
        assert wrapped == angle


def test_rates_of_many_turns_are_kept() -> None:
    model = MODEL[6]
    x = np.zeros(model.n_x)
    at = model.state_names.index("azimuth_rate_rad_s")
    x[at] = 20.0
    assert call(model.retract, x, x)[at] == 40.0
    assert call(model.difference, x, -x)[at] == 40.0


def test_plain_and_wrapped_components() -> None:
    """The function by itself: only the second of three components is an angle."""
    retract, difference = additive_manifold([False, True, False])
    assert call(retract, [3.0, 3.0, 3.0], [1.0, 1.0, 1.0]) == pytest.approx(
        [4.0, 4.0 - 2 * np.pi, 4.0], abs=ROUNDING
    )
    assert call(difference, [3.0, 3.0, 3.0], [-3.0, -3.0, -3.0]) == pytest.approx(
        [6.0, 6.0 - 2 * np.pi, 6.0], abs=ROUNDING
    )
