"""Moving a state and taking the difference of two: angles go the short way round."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from models.free_pen import N_FREE, SIGMA
from models.manifold import additive_manifold
from models.pen import pen_model
from models.sensor_kinds.accelerometer import Accelerometer
from tests.models.pens import ACCELEROMETER, Array, call, pen
from tests.references.free_states import still_state
from tests.references.free_tangent import tangent_of

SENSORS = {"accel": Accelerometer(**ACCELEROMETER, bias_std_m_s2=0.3)}
MODEL = {n: pen_model(pen(n, SENSORS)) for n in (5, 6)}
PAPER, FREE = MODEL[5], MODEL[6]
ANGLES = slice(3, 5)
"""Of the pen with five degrees of freedom."""

# |a + b| up to 2π is rounded to 1e-15 before it is wrapped.
ROUNDING = 4e-15
TURNED_ROUNDING = 1e-13
"""Of vectors up to π and a σ of up to 1, turned to and fro."""


def vector(draw: st.DrawFn, n: int, limit: float) -> Array:
    return np.array(draw(st.lists(st.floats(-limit, limit), min_size=n, max_size=n)))


def shorter(v: Array, limit: float) -> Array:
    """A vector of at most this length, in the same direction."""
    return v / max(1.0, float(np.linalg.norm(v)) / limit)


@st.composite
def states_and_moves(draw: st.DrawFn) -> tuple[Array, Array]:
    """Draw a state of five degrees of freedom, and a move with angles shorter than half a turn."""
    return vector(draw, PAPER.n_x, np.pi), vector(draw, PAPER.n_x, 3.14)


@st.composite
def free_states_and_moves(draw: st.DrawFn) -> tuple[Array, Array]:
    """Draw a state of six, and a move that turns it by less than half a turn."""
    x, delta = vector(draw, FREE.n_x, np.pi), vector(draw, FREE.n_x, 3.14)
    x[SIGMA], delta[SIGMA] = shorter(x[SIGMA], 1.0), shorter(delta[SIGMA], 3.9)
    return x, delta


def apart(one: Array, other: Array) -> float:
    """Angle between the attitudes of two free states, by SciPy, rad."""
    R, R_other = (Rotation.from_mrp(x[SIGMA]) for x in (one, other))
    return float((R.inv() * R_other).magnitude())


def shadow(x: Array) -> Array:
    """The same attitude under its other three numbers."""
    other = x.copy()
    other[SIGMA] = -x[SIGMA] / (x[SIGMA] @ x[SIGMA])
    return other


@given(states_and_moves())
def test_difference_undoes_retract(drawn: tuple[Array, Array]) -> None:
    x, delta = drawn
    moved = call(PAPER.retract, x, delta)
    assert call(PAPER.difference, moved, x) == pytest.approx(delta, abs=ROUNDING)


@given(free_states_and_moves())
def test_difference_undoes_retract_of_the_free_pen(drawn: tuple[Array, Array]) -> None:
    x, delta = drawn
    moved = call(FREE.retract, x, delta)
    assert np.linalg.norm(moved[SIGMA]) <= 1 + ROUNDING
    assert call(FREE.difference, moved, x) == pytest.approx(delta, abs=TURNED_ROUNDING)


@given(states_and_moves())
def test_retract_undoes_difference(drawn: tuple[Array, Array]) -> None:
    """On the circle: the same attitude, not always the same number."""
    x, delta = drawn
    target = x + delta
    back = call(PAPER.retract, x, call(PAPER.difference, target, x))
    turns = (back - target)[ANGLES]
    assert np.cos(turns) == pytest.approx(np.ones(2), abs=1e-15)
    assert np.sin(turns) == pytest.approx(np.zeros(2), abs=ROUNDING)
    assert np.delete(back - target, ANGLES) == pytest.approx(0, abs=ROUNDING)


@given(free_states_and_moves(), free_states_and_moves())
def test_retract_undoes_difference_of_the_free_pen(
    drawn: tuple[Array, Array], other: tuple[Array, Array]
) -> None:
    """The same attitude, not always the same three numbers."""
    x, target = drawn[0], other[0]
    back = call(FREE.retract, x, call(FREE.difference, target, x))
    assert apart(back, target) < TURNED_ROUNDING
    assert np.delete(back - target, SIGMA) == pytest.approx(0, abs=TURNED_ROUNDING)


@given(states_and_moves(), st.integers(-3, 3))
def test_only_angles_are_wrapped(drawn: tuple[Array, Array], turns: int) -> None:
    """Whole turns of an angle change nothing; rates, positions and biases just add."""
    x, delta = drawn
    wound = x.copy()
    wound[ANGLES] += 2 * np.pi * turns
    moved = call(PAPER.retract, wound, delta)
    assert np.abs(moved[ANGLES]).max() <= np.pi + ROUNDING
    assert np.array_equal(np.delete(moved, ANGLES), np.delete(x + delta, ANGLES))
    difference = call(PAPER.difference, wound, x)
    assert difference == pytest.approx(np.zeros(len(x)), abs=2e-14)
    far = call(PAPER.difference, 10 * x, -10 * x)
    assert np.array_equal(np.delete(far, ANGLES), np.delete(20 * x, ANGLES))


@given(free_states_and_moves())
def test_a_shadow_is_the_same_attitude(drawn: tuple[Array, Array]) -> None:
    """It changes nothing; places, rates and biases just add."""
    x, delta = drawn
    x[SIGMA] += 0.05  # not zero, whose shadow is infinite
    wound = shadow(x)
    moved, same = call(FREE.retract, x, delta), call(FREE.retract, wound, delta)
    assert apart(moved, same) < TURNED_ROUNDING
    assert np.delete(moved - same, SIGMA) == pytest.approx(0, abs=TURNED_ROUNDING)
    difference = call(FREE.difference, wound, x)
    assert difference == pytest.approx(np.zeros(len(x)), abs=TURNED_ROUNDING)
    added = np.setdiff1d(np.arange(FREE.n_x), [*range(3, 9), *range(12, 15)])
    assert np.array_equal(moved[added], (x + delta)[added])
    far = call(FREE.difference, 10 * x, -10 * x)
    assert np.array_equal(far[added], 20 * x[added])


@pytest.mark.parametrize("angle", ["azimuth", "elevation"])
def test_across_the_seam(angle: str) -> None:
    """From 179° forward by 4° is -177°, and the way from there back is -4°."""
    at = PAPER.state_names.index(f"{angle}_rad")
    x, delta = np.zeros(PAPER.n_x), np.zeros(PAPER.n_x)
    x[at], delta[at] = np.deg2rad(179), np.deg2rad(4)
    moved = call(PAPER.retract, x, delta)
    assert moved[at] == pytest.approx(np.deg2rad(-177), abs=ROUNDING)
    assert call(PAPER.difference, x, moved)[at] == pytest.approx(-delta[at], abs=ROUNDING)
    assert call(PAPER.difference, moved, x)[at] == pytest.approx(delta[at], abs=ROUNDING)


@pytest.mark.parametrize(
    ("before", "axis", "after"),
    [
        ((179, 50, 20), (0, 0, 1), (-177, 50, 20)),
        ((30, 89, 20), (np.sin(np.pi / 6), -np.cos(np.pi / 6), 0), (-150, 87, -160)),
        ((30, -89, 20), (-np.sin(np.pi / 6), np.cos(np.pi / 6), 0), (-150, -87, -160)),
        ((0, 50, 179), (np.cos(np.deg2rad(50)), 0, np.sin(np.deg2rad(50))), (0, 50, -177)),
    ],
    ids=["azimuth", "over the top", "upside down", "spin"],
)
def test_the_free_pen_across_the_seam(
    before: tuple[float, ...], axis: tuple[float, ...], after: tuple[float, ...]
) -> None:
    """Turned by 4° about an axis of the world, and read as angles; and the way back."""
    azimuth, elevation, spin = np.deg2rad(before)
    x, delta = np.zeros(FREE.n_x), np.zeros(FREE.n_x)
    x[:N_FREE] = still_state(elevation, azimuth, spin)
    turn = Rotation.from_rotvec(np.deg2rad(4) * np.array(axis))
    delta[SIGMA] = tangent_of(Rotation.from_mrp(x[SIGMA]), turn)
    moved = call(FREE.retract, x, delta)
    assert FREE.outputs is not None
    read = dict(zip(FREE.outputs.names, call(FREE.outputs.function, moved), strict=True))
    angles = [read[f"{name}_rad"] for name in ("azimuth", "elevation", "spin")]
    assert np.rad2deg(angles) == pytest.approx(after, abs=1e-9)
    back = np.zeros(FREE.n_x)
    back[SIGMA] = tangent_of(Rotation.from_mrp(moved[SIGMA]), turn.inv())
    assert call(FREE.difference, x, moved) == pytest.approx(back, abs=ROUNDING)
    assert call(FREE.difference, moved, x) == pytest.approx(delta, abs=ROUNDING)


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


@pytest.mark.parametrize(
    ("n", "rate"), [(5, "azimuth_rate_rad_s"), (6, "body_rate_x_rad_s"), (6, "body_rate_z_rad_s")]
)
def test_rates_of_many_turns_are_kept(n: int, rate: str) -> None:
    model = MODEL[n]
    x = np.zeros(model.n_x)
    at = model.state_names.index(rate)
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
