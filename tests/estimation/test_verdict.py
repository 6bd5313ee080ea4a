"""Unobservable directions in words, and the verdict on each state."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from estimation.observability import (
    UnobservableDirection,
    Verdict,
    free_motion,
    observability_matrix,
    verdict,
)
from estimation.recording import Measurement
from models.pen import pen_model
from models.sensor_kinds.gyroscope import Gyroscope
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
from tests.models.pens import GYROSCOPE, call, pen

pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.mark.parametrize(("n_q", "inertial", "tip_seen_by"), CONFIGURATIONS)
@pytest.mark.parametrize("moving", [False, True])
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
        column = np.zeros(model.n_x)
        for name, amount in direction.changes.items():
            column[model.state_names.index(name)] = amount
            assert direction.units[name] == model.state_units[model.state_names.index(name)]
        columns.append(column / found.prior_std)
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
    """Zero azimuth: e_ρ is x, so a tilt by 1 looks like an acceleration of -9.81 along x.

    The acceleration leads: in deviations of the prior it is the larger of the two.
    """
    x = first_state(6)
    x[3] = x[5] = 0.0
    found = motion(configured(6, "accel+gyro", "nothing"), x, second()).observability
    assert leading_once(found.directions)
    cos = np.cos(POSE[4])
    assert [direction.words for direction in found.directions] == [
        *(f"tip_{axis}_m alone" for axis in "xyz"),
        "azimuth_rad alone",
        *(f"tip_{axis}_velocity_m_s alone" for axis in "xyz"),
        f"tip_x_acceleration_m_s2 by 1 with elevation_rad by {-1 / 9.81:.3g}",
        f"tip_y_acceleration_m_s2 by 1 with spin_rad by {-1 / (9.81 * cos):.3g}",
    ]


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


def test_unseen_fraction_is_what_infinitely_good_readings_leave() -> None:
    """P = (I + OᵀO)⁻¹ in prior units: 1 / (1 + s²) in every direction, 1 where s = 0."""
    along = motion(configured(6, "accel", "nothing"), first_state(6), second())
    matrix = observability_matrix(along.model, along.measurements, along.states)
    variance = np.diag(np.linalg.inv(np.eye(18) + matrix.T @ matrix))
    found = along.observability
    unseen = found.unseen_fraction**2
    weakest = found.singular_values[found.rank - 1]
    rounding = 1e-7  # the matrix's condition is 1e8
    assert (variance > unseen - rounding).all()
    assert (variance < unseen + 1 / (1 + weakest**2) + rounding).all()
    assert unseen.min() < 1e-18
    assert unseen.max() == pytest.approx(1.0, abs=1e-9)
    assert unseen.sum() == pytest.approx(found.unobservable.shape[1], abs=1e-9)


def test_free_motions_obey_the_model_exactly() -> None:
    model = configured(6, "accel+gyro", "area")
    x = first_state(6, RATES, ACCELERATIONS)
    measurements, states = free_motion(model, x, duration_s=0.4, steps=8)
    times = np.array([measurement.time_s for measurement in measurements])
    np.testing.assert_allclose(times, 0.05 * np.arange(9), atol=1e-15)
    q, v, a = (x[6 * i : 6 * i + 6] for i in range(3))
    t = times[:, None]
    expected = np.hstack([q + v * t + a * t**2 / 2, v + a * t, a + 0 * t])
    np.testing.assert_allclose(states, expected, atol=1e-12)
    for measurement, state in zip(measurements, states, strict=True):
        readings = np.concatenate([call(sensor.h, state) for sensor in model.sensors])
        np.testing.assert_array_equal(measurement.y, readings)


@cache
def verdict_with(seen_by: str) -> Verdict:
    """Three seconds of a gently moving pen, with the process noise of a writing hand."""
    process = {
        "tip_jerk_density_m_s3_per_sqrt_hz": 10.0,
        "angle_jerk_density_rad_s3_per_sqrt_hz": 20.0,
    }
    x = first_state(6, 0.3 * RATES, 0.05 * ACCELERATIONS)
    model = configured(6, "accel+gyro", seen_by, process_noise=process)
    along = motion(model, x, np.arange(76) / 25)
    return verdict(model, along.measurements, along.states)


def test_with_an_area_the_elevation_is_seen_and_the_azimuth_is_not() -> None:
    found = verdict_with("area")
    assert not found.sees("azimuth_rad")
    assert found.sees("elevation_rad")
    assert found.sees("azimuth_rate_rad_s")
    (heading,) = found.observability.directions
    assert next(iter(heading.changes)) == "azimuth_rad"


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
    """At rest, then writing: of a lone accelerometer 11 directions stay, then 7."""
    model = configured(6, "accel", "nothing")
    still, moving = first_state(6), first_state(6, RATES, ACCELERATIONS)
    ranks = []
    for last in (still, moving):
        states = np.array([still] * 10 + [last] * 10)
        readings = [call(model.sensor("accel").h, x) for x in states]
        measurements = [Measurement(0.01 * k, y) for k, y in enumerate(readings)]
        ranks.append(verdict(model, measurements, states).observability.rank)
    assert ranks == [7, 11]
