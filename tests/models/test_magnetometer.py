"""A magnetometer: what it reads, by SciPy's rotations, and that it shows where north is."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pen_mhe as pm
from estimation.information_bound import information_bound
from models.errors import InputError
from models.free_pen import SIGMA
from models.level import from_gravity_frame, up_direction
from models.pen import pen_model
from models.pen_file import parse_pen
from models.sensor_kinds.magnetometer import Magnetometer
from tests.compass import FIELD, SENSORS, azimuth_error, compass_pen, written
from tests.models.pens import call, pen, random_rotation, random_state

MAGNETOMETER: dict[str, Any] = {**FIELD, "noise_std_ut": 0.4}
LIMIT_DEG = 2.0
"""Criterion: azimuth of handwriting with biases, RMS from the first second on, over all seeds."""
SEEDS = range(200, 210)
"""Of no other use."""


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("level_rad", [(0.0, 0.0), (0.1, -0.2)])
def test_it_reads_the_field_in_its_axes(
    degrees_of_freedom: int, level_rad: tuple[float, float]
) -> None:
    rng = np.random.default_rng(degrees_of_freedom)
    soft, hard = np.eye(3) + 0.05 * rng.standard_normal((3, 3)), rng.normal(0, 20.0, 3)
    mounting = random_rotation(rng)
    sensor = Magnetometer(
        **MAGNETOMETER,
        field_azimuth_deg=30.0,
        sensor_to_body=mounting,
        sensitivity=soft.tolist(),
        bias_ut=hard.tolist(),
        axes=("z", "x"),
    )  # type: ignore[call-arg]
    config = pen(degrees_of_freedom, {"mag": sensor}, level_rad=level_rad)
    x = random_state(rng, degrees_of_freedom)
    if degrees_of_freedom == 6:
        body_to_world = Rotation.from_mrp(x[3:6])
    else:
        angles = [x[3], np.pi / 2 - x[4], config.fixed_spin_rad]
        body_to_world = Rotation.from_euler("ZYZ", angles)
    dip, north = np.radians([64.0, 30.0])
    field = 48.0 * np.array(
        [np.cos(dip) * np.cos(north), np.cos(dip) * np.sin(north), -np.sin(dip)]
    )
    in_paper = Rotation.from_rotvec([*level_rad, 0.0]).apply(field)
    in_sensor = np.array(mounting).T @ body_to_world.inv().apply(in_paper)
    read = call(pen_model(config).sensor("mag").h, x)
    np.testing.assert_allclose(read, (soft @ in_sensor + hard)[[2, 0]], rtol=0, atol=1e-12)


def test_gravitys_frame_is_turned_as_up_is() -> None:
    level = (0.3, -0.4)
    turned = from_gravity_frame((1.0, 2.0, -3.0), up_direction(level))
    expected = Rotation.from_rotvec([*level, 0.0]).apply([1.0, 2.0, -3.0])
    np.testing.assert_allclose(turned, expected, rtol=0, atol=1e-14)
    assert from_gravity_frame((1.0, 2.0, 3.0), (0.0, 0.0, 1.0)) == (1.0, 2.0, 3.0)


def test_its_iron_is_a_state_where_it_is_unknown() -> None:
    sensor = {"kind": "magnetometer", **FIELD, "noise_std_mgauss": 4.0, "bias_std_ut": 3.0}
    model = pen_model(parse_pen({"name": "p", "sensors": {"mag": sensor}}))
    assert model.state_names[18:] == ("mag_bias_x_ut", "mag_bias_y_ut", "mag_bias_z_ut")
    assert model.state_units[18:] == ("µT",) * 3
    assert model.sensor("mag").noise_std == pytest.approx([0.4] * 3)


def test_the_place_must_be_told() -> None:
    with pytest.raises(InputError, match=r"sensors\.mag\.field_strength_ut: is missing"):
        parse_pen({"name": "p", "sensors": {"mag": {"kind": "magnetometer", "noise_std_ut": 1.0}}})


def test_observe_says_that_azimuth_is_seen() -> None:
    """With it, and not without."""
    for sensors, is_seen in ((SENSORS, True), (SENSORS[:2], False)):
        found = pm.observe(compass_pen(), sensors, motions=["handwriting"], duration_s=0.5)
        assert found.by_motion["handwriting"].sees("azimuth_rad") == is_seen
        row = next(row for row in found.rows() if row[0] == "azimuth_rad")
        assert row[2].startswith("not observable") != is_seen


@pytest.mark.parametrize("level_rad", [(0.0, 0.0), (0.1, -0.2)])
def test_the_turn_about_the_field_is_unseen_along_one_tangent_vector(
    level_rad: tuple[float, float],
) -> None:
    """Of all states; in the heading's frame it is another at each."""
    sensor = Magnetometer(**MAGNETOMETER)  # type: ignore[call-arg]
    model = pen_model(pen(6, {"mag": sensor}, level_rad=level_rad))
    x, d = ca.SX.sym("x", model.n_x), ca.SX.sym("d", model.n_x)
    read = model.sensor("mag").h(model.retract(x, d))
    slope = ca.Function("H", [x, d], [ca.jacobian(read, d)])
    field = np.array(sensor.field_ut(up_direction(level_rad)))
    rng = np.random.default_rng(32)
    for _ in range(5):
        state = np.zeros(model.n_x)
        state[:18] = random_state(rng, 6)[:18]
        H = slope(state, np.zeros(model.n_x)).full()[:, SIGMA]
        np.testing.assert_allclose(H @ field / 48.0, 0.0, rtol=0, atol=1e-11)
        assert np.linalg.matrix_rank(H, tol=1.0) == 2


def test_no_more_heading_is_claimed_than_the_bound_along_the_truth() -> None:
    """While tilt and heading come in; with tilts in the heading's frame 0.6 of it was."""
    recording = written(SEEDS[0], 1.0)
    model = pm.pen_model(compass_pen(), SENSORS)
    history = pm.run(pm.create_estimator("ekf", model), recording)
    assert recording.truth is not None
    states = recording.truth.states(model.state_names, history.time_s)
    bound = information_bound(model, recording.measurements(model), states)
    known = bound.std[:, bound.names.index("azimuth_rad")]
    early = history.time_s >= 0.05
    ratio = history.std_of("azimuth_rad")[early] / known[early]
    assert 0.85 < ratio.min() < ratio.max() < 1.15


def rms_deg(estimator: str, seeds: range) -> float:
    built = pm.create_estimator(estimator, pm.pen_model(compass_pen(), SENSORS))
    errors = []
    for seed in seeds:
        recording = written(seed)
        history = pm.run(built, recording)
        errors.append(azimuth_error(history, recording)[history.time_s >= 1.0])
    return float(np.degrees(np.sqrt(np.mean(np.concatenate(errors) ** 2))))


def test_azimuth_of_handwriting() -> None:
    assert rms_deg("ekf", SEEDS[:1]) < LIMIT_DEG


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["ekf", "mhe-rti"])
def test_azimuth_of_handwriting_over_all_seeds(estimator: str) -> None:
    assert rms_deg(estimator, SEEDS) < LIMIT_DEG
