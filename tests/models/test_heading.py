"""The heading of a pen: turned about a vertical axis, all but a camera read the same."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.arrays import Array
from models.heading import free_heading_symmetry, heading_symmetry
from models.pen import pen_model
from models.state_space import StateSpaceModel
from tests.models.pens import call, every_sensor, pen, random_state

CENTRE_M = np.array([0.1, 0.2, 0.0])
"""Of the writing area in `every_sensor`."""

ANGLES = (-4.0, -0.3, 1e-6, 0.5, np.pi, 5.0)
INERTIAL = ("accel", "gyro")


@cache
def a_pen(degrees_of_freedom: int) -> tuple[StateSpaceModel, Array]:
    """A pen with one sensor of every kind, off its axis and with biases, in a brisk state."""
    rng = np.random.default_rng(degrees_of_freedom)
    model = pen_model(pen(degrees_of_freedom, every_sensor(rng)))
    return model, random_state(rng, degrees_of_freedom, model.n_x - 3 * degrees_of_freedom)


def turned(model: StateSpaceModel, x: Array, angle: float) -> Array:
    """The state turned by the model's own symmetry."""
    (symmetry,) = model.symmetries
    return call(symmetry, x, angle)


def long_axis(x: Array, degrees_of_freedom: int) -> Array:
    """From tip to top: e_r = (cosθ cosφ, cosθ sinφ, sinθ)."""
    if degrees_of_freedom == 6:
        return np.asarray(Rotation.from_mrp(x[3:6]).apply([0.0, 0.0, 1.0]))
    azimuth, elevation = x[3:5]
    level = np.cos(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])
    return np.array([*level, np.sin(elevation)])


pytestmark = pytest.mark.parametrize("degrees_of_freedom", [5, 6])


def test_no_angle_changes_nothing(degrees_of_freedom: int) -> None:
    model, x = a_pen(degrees_of_freedom)
    np.testing.assert_allclose(turned(model, x, 0.0), x, rtol=0, atol=1e-16)


@pytest.mark.parametrize("first", ANGLES)
@pytest.mark.parametrize("second", ANGLES)
def test_flows_add(degrees_of_freedom: int, first: float, second: float) -> None:
    model, x = a_pen(degrees_of_freedom)
    one_by_one = turned(model, turned(model, x, first), second)
    at_once = turned(model, x, first + second)
    np.testing.assert_allclose(one_by_one, at_once, rtol=1e-14, atol=1e-14)


def test_a_full_turn_is_none(degrees_of_freedom: int) -> None:
    model, x = a_pen(degrees_of_freedom)
    away = call(model.difference, turned(model, x, 2 * np.pi), x)
    np.testing.assert_allclose(away, 0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("angle", ANGLES)
def test_vectors_turn_about_the_vertical(degrees_of_freedom: int, angle: float) -> None:
    """Tip about the centre, velocity, acceleration and the attitude; nothing else moves."""
    model, x = a_pen(degrees_of_freedom)
    seen, n_q = turned(model, x, angle), degrees_of_freedom
    turn = Rotation.from_euler("z", angle)
    tip = CENTRE_M + turn.apply(x[:3] - CENTRE_M)
    np.testing.assert_allclose(seen[:3], tip, rtol=0, atol=1e-15)
    for start in (n_q, 2 * n_q):
        rows = slice(start, start + 3)
        np.testing.assert_allclose(seen[rows], turn.apply(x[rows]), rtol=0, atol=1e-14)
    axis, seen_axis = long_axis(x, n_q), long_axis(seen, n_q)
    np.testing.assert_allclose(seen_axis, turn.apply(axis), rtol=0, atol=1e-14)
    attitude = range(3, 6) if n_q == 6 else range(3, 4)
    moved = {*range(3), *attitude, *range(n_q, n_q + 3), *range(2 * n_q, 2 * n_q + 3)}
    rest = [i for i in range(model.n_x) if i not in moved]
    np.testing.assert_array_equal(seen[rest], x[rest])


@pytest.mark.parametrize("angle", ANGLES)
def test_an_attitude_turns_as_a_whole(degrees_of_freedom: int, angle: float) -> None:
    """Body to world, by SciPy; with five degrees of freedom what moves is the azimuth alone."""
    model, x = a_pen(degrees_of_freedom)
    seen = turned(model, x, angle)
    if degrees_of_freedom == 5:
        assert seen[3] == pytest.approx(x[3] + angle, abs=1e-15)
        return
    expected = Rotation.from_euler("z", angle) * Rotation.from_mrp(x[3:6])
    away = (expected.inv() * Rotation.from_mrp(seen[3:6])).magnitude()
    assert away < 1e-14
    assert np.linalg.norm(seen[3:6]) <= 1 + 1e-15


@pytest.mark.parametrize("angle", ANGLES)
def test_rates_and_specific_forces_stay(degrees_of_freedom: int, angle: float) -> None:
    """Of sensors off the axis, turned in the body and biased."""
    model, x = a_pen(degrees_of_freedom)
    for name in INERTIAL:
        h = model.sensor(name).h
        np.testing.assert_allclose(
            call(h, turned(model, x, angle)), call(h, x), rtol=1e-12, atol=1e-12
        )


@pytest.mark.parametrize("angle", ANGLES)
def test_the_distance_to_the_centre_stays(degrees_of_freedom: int, angle: float) -> None:
    """The tip's, and that of the target that the camera sees; heights too."""
    model, x = a_pen(degrees_of_freedom)
    seen, camera = turned(model, x, angle), model.sensor("camera").h
    for before, after in ((x[:3], seen[:3]), (call(camera, x)[:3], call(camera, seen)[:3])):
        radius, same = (np.linalg.norm(place - CENTRE_M) for place in (before, after))
        assert same == pytest.approx(radius, rel=1e-14)
        assert after[2] == pytest.approx(before[2], abs=1e-15)


def test_a_camera_sees_the_turn(degrees_of_freedom: int) -> None:
    """It reads a position elsewhere, and an attitude turned by exactly this angle."""
    model, x = a_pen(degrees_of_freedom)
    camera = model.sensor("camera").h
    before, after = call(camera, x), call(camera, turned(model, x, 0.5))
    assert np.linalg.norm(after[:3] - before[:3]) > 0.01
    turn = Rotation.from_rotvec(after[3:]) * Rotation.from_rotvec(before[3:]).inv()
    np.testing.assert_allclose(turn.as_rotvec(), [0, 0, 0.5], rtol=0, atol=1e-13)


def test_it_goes_on_as_it_would_have(degrees_of_freedom: int) -> None:
    """First turned, then moved without noise, or the other way round."""
    model, x = a_pen(degrees_of_freedom)
    no_noise = np.zeros(model.n_w)
    turned_first = call(model.f, turned(model, x, 0.7), no_noise, 0.1)
    moved_first = turned(model, call(model.f, x, no_noise, 0.1), 0.7)
    away = call(model.difference, turned_first, moved_first)
    np.testing.assert_allclose(away, 0, rtol=0, atol=1e-13)


def test_the_centre_is_the_origin_without_an_area(degrees_of_freedom: int) -> None:
    rng = np.random.default_rng(0)
    config = pen(degrees_of_freedom, every_sensor(rng))
    model = pen_model(config, INERTIAL, writing_area=False)
    x = random_state(rng, degrees_of_freedom, model.n_x - 3 * degrees_of_freedom)
    own = (
        free_heading_symmetry(model.n_x)
        if degrees_of_freedom == 6
        else heading_symmetry(degrees_of_freedom, model.n_x)
    )
    np.testing.assert_array_equal(turned(model, x, 0.4), call(own, x, 0.4))
    turn = Rotation.from_euler("z", 0.4)
    np.testing.assert_allclose(turned(model, x, 0.4)[:3], turn.apply(x[:3]), rtol=0, atol=1e-15)
