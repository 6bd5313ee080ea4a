"""Symmetries: which sensors are blind to a pen's heading, and which way it goes."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimation.symmetry import direction, holds
from models.arrays import Array
from models.heading import free_heading_symmetry
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from pen_mhe.sensor_verdict import judge, observe
from recordings.simulate_pen import simulate

pytestmark = pytest.mark.usefixtures("interpreted")

STEP_S, SIGMA = 0.01, slice(3, 6)
BLIND = {
    "accelerometer": ("accel",),
    "gyroscope": ("gyro",),
    "both": ("accel", "gyro"),
    "two accelerometers": ("accel_lower", "accel_upper"),
}
"""Choices of the reference pen's sensors that cannot see a heading."""


def model_of(
    sensors: tuple[str, ...],
    writing_area: bool = True,
    pen: str = "reference",
    degrees_of_freedom: int = 6,
) -> StateSpaceModel:
    level = {"degrees_of_freedom": degrees_of_freedom, "level_rad": (0.0, 0.0)}
    config = load_pen(pen).model_copy(update=level)
    return pen_model(config, sensors, writing_area=writing_area)


def states_of(model: StateSpaceModel) -> Array:
    """States (8, n_x) drawn from the prior."""
    draws = np.random.default_rng(9).standard_normal((8, model.n_x))
    states = model.prior.mean + model.prior.std * draws
    if model.outputs is not None:
        mean = Rotation.from_mrp(model.prior.mean[SIGMA].copy())
        turns = Rotation.from_rotvec(model.prior.std[SIGMA] * draws[:, SIGMA])
        states[:, SIGMA] = (mean * turns).as_mrp()
    return states


def heading_holds(model: StateSpaceModel) -> bool:
    (symmetry,) = model.symmetries
    return holds(model, symmetry, states_of(model), STEP_S)


@pytest.mark.cover
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("writing_area", [True, False])
@pytest.mark.parametrize("name", BLIND)
def test_no_inertial_sensor_sees_the_heading(
    name: str, writing_area: bool, degrees_of_freedom: int
) -> None:
    """Nor does a writing area: it looks the same from all sides of its centre."""
    model = model_of(BLIND[name], writing_area, degrees_of_freedom=degrees_of_freedom)
    areas = [sensor for sensor in model.sensors if sensor.kind == "writing_area"]
    assert len(areas) == writing_area
    assert heading_holds(model)


@pytest.mark.parametrize("sensors", [("camera",), ("accel", "gyro", "camera"), ("area", "camera")])
def test_a_camera_sees_the_heading(sensors: tuple[str, ...]) -> None:
    assert not heading_holds(model_of(sensors))


def test_an_area_has_one_centre() -> None:
    """The D-POINT pen's lies around (0.1, 0.1) m: about its own centre only it stays as it is."""
    model = model_of(("accel", "gyro"), pen="dpoint")
    centre = model.sensor("area").constant_reading
    np.testing.assert_array_equal(centre, [0.1, 0.1, 0.0])
    assert heading_holds(model)
    for elsewhere in (None, np.array([0.1, 0.09, 0.0])):
        other = model.replace(symmetries=(free_heading_symmetry(model.n_x, centre_m=elsewhere),))
        assert not heading_holds(other)
    # The axis is vertical: its height says nothing.
    higher = model.replace(
        symmetries=(free_heading_symmetry(model.n_x, centre_m=np.array([0.1, 0.1, 0.3])),)
    )
    assert heading_holds(higher)


def test_without_an_area_every_centre_is_as_good() -> None:
    model = model_of(("accel", "gyro"), writing_area=False, pen="dpoint")
    for centre in (np.zeros(3), np.array([0.4, -0.2, 0.1])):
        symmetry = free_heading_symmetry(model.n_x, centre_m=centre)
        assert heading_holds(model.replace(symmetries=(symmetry,)))


def test_one_state_that_shows_it_is_enough() -> None:
    """A tip at rest on the wrong axis stays where it is; in any other state it moves."""
    model = model_of(("accel", "gyro"), pen="dpoint")
    wrong = free_heading_symmetry(model.n_x, centre_m=np.array([0.1, 0.2, 0.0]))
    on_its_axis = model.prior.mean.copy()
    on_its_axis[:3] = [0.1, 0.2, 0.0]
    assert holds(model, wrong, on_its_axis[None, :], STEP_S)
    assert not holds(model, wrong, np.vstack([on_its_axis, states_of(model)[:1]]), STEP_S)


def test_the_motion_too_has_to_go_on_alike() -> None:
    """Neither sensor reads a place. A tip that lies elsewhere moves on as it would have; one
    that is moved by its own velocity does not, as that changes.
    """
    model = model_of(("accel", "gyro"), writing_area=False)
    x, angle = ca.SX.sym("x", model.n_x), ca.SX.sym("angle")
    velocity = model.state_names.index("tip_x_velocity_m_s")
    for shift, goes_on in ((angle, True), (angle * x[velocity], False)):
        moved = ca.vertcat(x[0] + shift, x[1:])
        symmetry = ca.Function("shifted", [x, angle], [moved])
        assert holds(model, symmetry, states_of(model), STEP_S) is goes_on


@pytest.mark.parametrize("azimuth", [0.4, np.pi - 1e-7])
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_the_direction_is_the_flows_slope(degrees_of_freedom: int, azimuth: float) -> None:
    """Against central differences, of third order in the step; also where the azimuth wraps."""
    model = model_of(("accel", "gyro"), degrees_of_freedom=degrees_of_freedom)
    (symmetry,) = model.symmetries
    x, h = states_of(model)[0], 1e-4
    if degrees_of_freedom == 5:
        x[3] = azimuth
    else:
        _, *lean = Rotation.from_mrp(x[SIGMA]).as_euler("ZYZ")
        x[SIGMA] = Rotation.from_euler("ZYZ", [azimuth, *lean]).as_mrp()
    ahead, behind = (symmetry(x, step).full().ravel() for step in (h, -h))
    slope = model.difference(ahead, behind).full().ravel() / (2 * h)
    found = direction(model, symmetry, x)
    scale = np.abs(x) + np.abs(found)
    assert np.abs((found - slope) / np.where(scale > 0, scale, 1.0)).max() < h**2
    if degrees_of_freedom == 5:
        assert found[model.state_names.index("azimuth_rad")] == 1
    else:
        np.testing.assert_allclose(found[SIGMA], [0, 0, 1], rtol=0, atol=1e-15)


def test_the_direction_turns_with_the_centre() -> None:
    """ds/dα of a tip is e_z × (tip - centre); of its velocity e_z × velocity.

    A free pen's velocity turns with the attitude: nothing is left of it in the tangent space.
    """
    up = np.array([0.0, 0.0, 1.0])
    for degrees_of_freedom in (5, 6):
        model = model_of(("accel", "gyro"), pen="dpoint", degrees_of_freedom=degrees_of_freedom)
        (symmetry,) = model.symmetries
        x = states_of(model)[1]
        found = direction(model, symmetry, x)
        tip, velocity = x[:3] - [0.1, 0.1, 0.0], slice(degrees_of_freedom, degrees_of_freedom + 3)
        turned = np.cross(up, x[velocity])
        if degrees_of_freedom == 6:
            turned = turned - np.cross(found[SIGMA], x[velocity])
        np.testing.assert_allclose(found[:3], np.cross(up, tip), rtol=0, atol=1e-15)
        np.testing.assert_allclose(found[velocity], turned, rtol=0, atol=1e-15)
        assert np.abs(tip[:2]).min() > 0.01


@pytest.mark.parametrize("pen", ["reference", "dpoint"])
def test_the_azimuth_stays_unseen_however_long_the_motion(pen: str) -> None:
    """Ten seconds of handwriting within the writing area: no side of it is told."""
    motion = "handwriting"
    found = observe(load_pen(pen), ("accel", "gyro"), motions=[motion], duration_s=10.0)
    verdict = found.by_motion[motion]
    assert not verdict.sees("azimuth_rad")
    assert verdict.sees("elevation_rad")
    (heading,) = verdict.observability.directions
    assert next(iter(heading.changes)) == "turning about the vertical"


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_without_its_symmetry_the_azimuth_would_seem_seen(degrees_of_freedom: int) -> None:
    """By the area's linearised readings alone.

    Of a pen that cannot spin they leave a quarter of what was known before. Of a free pen the
    bound leaves most of it, but no direction in which nothing is seen.
    """
    sensors = ("accel", "gyro")
    config = load_pen("dpoint").model_copy(update={"degrees_of_freedom": degrees_of_freedom})
    model = pen_model(config, sensors).replace(symmetries=())
    found = judge(model, simulate(config, sensors, motion="handwriting", duration_s=10.0))
    assert found.observability.directions == ()
    assert found.observability.unseen_fraction[found.bound.names.index("azimuth_rad")] == 0
    assert found.sees("azimuth_rad") is (degrees_of_freedom == 5)
