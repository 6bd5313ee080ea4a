"""Unobservable directions in words, and the verdict on each state."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimation.observability import (
    UnobservableDirection,
    Verdict,
    free_motion,
    observability_matrix,
    verdict,
)
from estimation.recording import Measurement
from models.arrays import Array
from models.motion import AttitudeWhiteJerk, Motion, TipBoundedVelocity
from models.pen import pen_model
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.state_space import StateSpaceModel
from tests.estimation.exact_motions import (
    ACCELERATIONS,
    CONFIGURATIONS,
    POSE,
    RATES,
    SENSORS,
    configured,
    first_state,
    motion,
    second,
)
from tests.models.pens import ACCELEROMETER, GYROSCOPE, call, pen
from tests.references.free_tangent import attitude_outputs, heading_of, retracted

pytestmark = pytest.mark.usefixtures("interpreted")


def tangent_vector(model: StateSpaceModel, x: Array, direction: UnobservableDirection) -> Array:
    """Return the tangent vector (n_x,) of a direction; a free pen's are whole changes in the world.

    Its v and a turn with the attitude, its rates are the body's.
    """
    named = model.tangent
    names = model.state_names if named is None else named.names
    units = model.state_units if named is None else named.units
    vector = np.zeros(model.n_x)
    for name, amount in direction.changes.items():
        vector[names.index(name)] = amount
        assert direction.units[name] == units[names.index(name)]
    if model.tangent is not None:
        into_body = Rotation.from_mrp(x[3:6]).inv()
        for word in ("rate of turning about", "angular acceleration about"):
            part = [i for i, name in enumerate(names) if name.startswith(word)]
            assert len(part) == 3
            vector[part] = into_body.apply(vector[part])
        for start in (6, 12):
            part = slice(start, start + 3)
            vector[part] -= np.cross(vector[3:6], x[part])
        vector[3:6] = heading_of(Rotation.from_mrp(x[3:6])).inv().apply(vector[3:6])
    return vector


@pytest.mark.parametrize(("n_q", "inertial", "tip_seen_by"), CONFIGURATIONS)
@pytest.mark.parametrize("moving", [pytest.param(False, marks=pytest.mark.slow), True])
def test_each_direction_leaves_every_reading_as_it_is(
    n_q: int, inertial: str, tip_seen_by: str, moving: bool
) -> None:
    model = configured(n_q, inertial, tip_seen_by)
    x = first_state(n_q, RATES, ACCELERATIONS) if moving else first_state(n_q)
    along = motion(model, x, second())
    matrix = observability_matrix(model, along.measurements, along.states)
    if moving and tip_seen_by == "area" and inertial != "gyro":
        # A turn about the area's centre: an area that is linearised seems to show it.
        matrix = matrix.reshape(len(along.states), model.n_r, model.n_x)[:, :-3]
    found, columns = along.observability, []
    for direction in found.directions:
        columns.append(tangent_vector(model, x, direction) / model.prior.std)
        # The readings' largest change is 2e4 deviations: 1e-7 is rounding.
        assert np.abs(matrix @ columns[-1]).max() < 1e-7 * np.abs(columns[-1]).max()
    assert len(columns) == found.unobservable.shape[1]
    if columns:
        assert np.linalg.matrix_rank(np.array(columns)) == len(columns)


def test_directions_do_not_depend_on_the_basis_they_come_from() -> None:
    """Other instants, another basis of the same subspace: the same directions."""
    x = first_state(6)
    model = configured(6, "accel", "nothing")
    one, other = (motion(model, x, second(n)).observability for n in (21, 17))
    assert np.abs(one.unobservable - other.unobservable).max() > 0.1
    assert [list(d.changes) for d in one.directions] == [list(d.changes) for d in other.directions]
    for direction, same in zip(one.directions, other.directions, strict=True):
        amounts = [list(d.changes.values()) for d in (direction, same)]
        np.testing.assert_allclose(amounts[0], amounts[1], rtol=1e-9)


def leading_once(directions: tuple[UnobservableDirection, ...]) -> bool:
    leading = [next(iter(direction.changes)) for direction in directions]
    others = {name for d in directions for name in list(d.changes)[1:]}
    return len(set(leading)) == len(leading) and not others & set(leading)


def test_directions_in_words() -> None:
    """A turn by 1 about x looks like an acceleration of -g e_z × e_x, of -9.81 along y.

    The acceleration leads: in deviations of the prior it is the larger of the two.
    """
    x = first_state(6)
    found = motion(configured(6, "accel+gyro", "nothing"), x, second()).observability
    assert leading_once(found.directions)
    assert [direction.words for direction in found.directions] == [
        *(f"tip_{axis}_m alone" for axis in "xyz"),
        "turning about the vertical alone",
        *(f"tip_{axis}_velocity_m_s alone" for axis in "xyz"),
        f"tip_x_acceleration_m_s2 by 1 with turning about world y by {1 / 9.81:.3g}",
        f"tip_y_acceleration_m_s2 by 1 with turning about world x by {-1 / 9.81:.3g}",
    ]


def test_directions_of_a_pen_without_spin_in_words() -> None:
    """Zero azimuth: e_ρ is x, so a tilt by 1 looks like an acceleration of -9.81 along x."""
    x = first_state(5)
    x[3] = 0.0
    found = motion(configured(5, "accel+gyro", "nothing"), x, second()).observability
    assert leading_once(found.directions)
    assert [direction.words for direction in found.directions] == [
        *(f"tip_{axis}_m alone" for axis in "xyz"),
        "azimuth_rad alone",
        *(f"tip_{axis}_velocity_m_s alone" for axis in "xyz"),
        f"tip_x_acceleration_m_s2 by 1 with elevation_rad by {-1 / 9.81:.3g}",
    ]


def test_a_free_pens_biases_hide_a_tilt_and_a_rate() -> None:
    """Azimuth and spin zero, lying level along x: body axes are -z, y and x of the world.

    Within an area that keeps the tip: R δb_a = -g e_z × δϑ and δb_g = -Rᵀ e_z.
    """
    sensors = {
        **SENSORS,
        "accel": Accelerometer(**ACCELEROMETER, bias_std_m_s2=0.3),
        "gyro": Gyroscope(**GYROSCOPE, bias_std_rad_s=0.03),
    }
    x = np.concatenate([first_state(6, pose=np.zeros(6)), np.zeros(6)])
    found = motion(configured(6, "accel+gyro", "area", sensors), x, second()).observability
    assert leading_once(found.directions)
    assert sorted(direction.words for direction in found.directions) == sorted(
        [
            "turning about the vertical alone",
            f"accel_bias_y_m_s2 by 1 with turning about world x by {-1 / 9.81:.3g}",
            f"accel_bias_z_m_s2 by 1 with turning about world y by {1 / 9.81:.3g}",
            "gyro_bias_x_rad_s by 1 with rate of turning about the vertical by 1",
        ]
    )


def test_a_bias_of_the_gyroscope_looks_like_a_rate() -> None:
    """At rest ω = (-cosθ φ̇, -θ̇, sinθ φ̇) + b: b_y hides θ̇, and (b_x, b_z) φ̇."""
    gyro = Gyroscope(**GYROSCOPE, bias_std_rad_s=0.03)
    config = pen(5, {"gyro": gyro, "camera": SENSORS["camera"]}, fixed_spin_rad=0.0)
    x = np.concatenate([first_state(5), [0.01, -0.02, 0.03]])
    alone = pen_model(config, ["gyro"], writing_area=False)
    found = motion(alone, x, second()).observability
    cos, sin = np.cos(POSE[4]), np.sin(POSE[4])
    words = [direction.words for direction in found.directions]
    assert words[:11] == [
        *(f"tip_{axis}_m alone" for axis in "xyz"),
        "azimuth_rad alone",
        "elevation_rad alone",
        *(f"tip_{axis}_velocity_m_s alone" for axis in "xyz"),
        *(f"tip_{axis}_acceleration_m_s2 alone" for axis in "xyz"),
    ]
    assert words[11:] == [
        "gyro_bias_y_rad_s by 1 with elevation_rate_rad_s by 1",
        f"gyro_bias_z_rad_s by 1 with azimuth_rate_rad_s by {-1 / sin:.3g}, "
        f"gyro_bias_x_rad_s by {-cos / sin:.3g}",
    ]
    with_camera = pen_model(config, ["gyro", "camera"])
    assert motion(with_camera, x, second()).observability.directions == ()


@pytest.mark.parametrize("n_q", [5, 6])
def test_unseen_fraction_is_what_infinitely_good_readings_leave(n_q: int) -> None:
    """P = (I + OᵀO)⁻¹ in prior units: 1 / (1 + s²) in every direction, 1 where s = 0.

    Of what people read: g P gᵀ / g gᵀ with the gradient g of each.
    """
    x = first_state(n_q)
    along = motion(configured(n_q, "accel", "nothing"), x, second())
    matrix = observability_matrix(along.model, along.measurements, along.states)
    found, tangent = along.observability, along.model.tangent
    T = np.eye(3 * n_q) if tangent is None else tangent.function(x).full()
    of_changes = np.linalg.inv(T) * found.prior_std  # a tangent vector of each change
    matrix = matrix / along.model.prior.std @ of_changes
    P = np.linalg.inv(np.eye(3 * n_q) + matrix.T @ matrix)
    g = gradients(found.names, x) @ of_changes
    variance = np.einsum("oi,ij,oj->o", g, P, g) / (g**2).sum(axis=1)
    unseen = found.unseen_fraction**2
    weakest = found.singular_values[found.rank - 1]
    rounding = 1e-7  # the matrix's condition is 1e8
    assert (variance > unseen - rounding).all()
    assert (variance < unseen + 1 / (1 + weakest**2) + rounding).all()
    assert unseen.max() == pytest.approx(1.0, abs=1e-9)
    if n_q == 5:  # a free pen's body axes are not those of a direction, nor are its angles
        assert unseen.min() < 1e-18
        assert unseen.sum() == pytest.approx(found.unobservable.shape[1], abs=1e-9)


def gradients(names: tuple[str, ...], x: Array) -> Array:
    """Of states, and of a free pen's attitude outputs by five-point differences, (n_o, n_x)."""
    n_x, h = len(x), 1e-3
    if n_x == 15:
        return np.eye(15)

    def outputs(d: Array) -> Array:
        moved = retracted(x, d)
        rest = iter([*moved[:3], *moved[6:]])
        shown = attitude_outputs(moved)
        return np.array([shown[name] if name in shown else next(rest) for name in names])

    columns = [
        (8 * (outputs(h * e) - outputs(-h * e)) - outputs(2 * h * e) + outputs(-2 * h * e))
        / (12 * h)
        for e in np.eye(n_x)
    ]
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("n_q", [5, 6])
def test_free_motions_obey_the_model_exactly(n_q: int) -> None:
    model = configured(n_q, "accel+gyro", "area")
    x = first_state(n_q, RATES, ACCELERATIONS)
    measurements, states = free_motion(model, x, duration_s=0.4, steps=8)
    times = np.array([measurement.time_s for measurement in measurements])
    np.testing.assert_allclose(times, 0.05 * np.arange(9), atol=1e-15)
    q, v, a = (x[n_q * i : n_q * i + n_q] for i in range(3))
    t = times[:, None]
    expected = np.hstack([q + v * t + a * t**2 / 2, v + a * t, a + 0 * t])
    if n_q == 6:
        attitude, turned = Rotation.from_mrp(x[3:6]), []
        for k in range(9):
            turned.append(attitude.as_mrp())
            rate = v[3:] + 0.05 * k * a[3:]
            attitude = attitude * Rotation.from_rotvec(0.05 * rate + 0.05**2 / 2 * a[3:])
        expected[:, 3:6] = turned
    np.testing.assert_allclose(states, expected, atol=1e-12)
    for measurement, state in zip(measurements, states, strict=True):
        readings = np.concatenate([call(sensor.h, state) for sensor in model.sensors])
        np.testing.assert_array_equal(measurement.y, readings)


@cache
def verdict_with(seen_by: str) -> Verdict:
    """Three seconds of a gently moving pen, with the process noise of a writing hand."""
    hand = Motion(
        tip=TipBoundedVelocity(speed_m_s=0.15, correlation_time_s=0.1),
        attitude=AttitudeWhiteJerk(jerk_density_rad_s3_per_sqrt_hz=20.0),
    )
    x = first_state(6, 0.3 * RATES, 0.05 * ACCELERATIONS)
    model = configured(6, "accel+gyro", seen_by, motion=hand)
    along = motion(model, x, np.arange(76) / 25)
    return verdict(model, along.measurements, along.states)


def test_with_an_area_the_elevation_is_seen_and_the_azimuth_is_not() -> None:
    found = verdict_with("area")
    assert not found.sees("azimuth_rad")
    assert found.sees("elevation_rad")
    assert found.sees("body_rate_z_rad_s")
    (heading,) = found.observability.directions
    assert next(iter(heading.changes)) == "turning about the vertical"


def test_with_a_camera_every_state_is_seen() -> None:
    found = verdict_with("camera")
    assert found.observability.directions == ()
    assert [name for name in found.bound.names if not found.sees(name)] == []


def test_a_verdict_takes_the_worse_of_gramian_and_bound() -> None:
    found = verdict_with("camera")
    names = found.bound.names
    only_tip = np.eye(18)[:, :1]
    blind = dataclasses.replace(found.observability, unobservable=only_tip)
    std = found.bound.std.copy()
    std[-1, names.index("spin_rad")] = 0.31 * found.bound.prior_std[names.index("spin_rad")]
    noisy = dataclasses.replace(found.bound, std=std)
    worse = Verdict(blind, noisy)
    assert [name for name in names if not worse.sees(name)] == ["tip_x_m", "spin_rad"]
    assert worse.unseen_fraction[0] == 1.0
    assert worse.unseen_fraction[names.index("spin_rad")] == pytest.approx(0.31, rel=1e-12)


def test_what_a_part_of_a_motion_shows_is_shown() -> None:
    """At rest, then writing: of a lone accelerometer 11 directions stay, then 9."""
    model = configured(6, "accel", "nothing")
    still, moving = first_state(6), first_state(6, RATES, ACCELERATIONS)
    ranks = []
    for last in (still, moving):
        states = np.array([still] * 10 + [last] * 10)
        readings = [call(model.sensor("accel").h, x) for x in states]
        measurements = [Measurement(0.01 * k, y) for k, y in enumerate(readings)]
        ranks.append(verdict(model, measurements, states).observability.rank)
    assert ranks == [7, 9]
