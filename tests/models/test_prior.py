"""What a pen file says of the start reaches the state it is about."""

from __future__ import annotations

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.free_pen import SIGMA
from models.motion import Motion, TipBoundedVelocity, TipMatern, TipMotion, TipWhiteJerk
from models.pen import pen_model
from models.pen_config import PenConfig, Prior
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.state_space import StateSpaceModel
from tests.models.pens import (
    ACCELEROMETER,
    CAMERA,
    FIXED_SPIN_RAD,
    GYROSCOPE,
    Array,
    call,
    pen,
)
from tests.references.free_states import body_to_world, still_state
from tests.references.free_tangent import heading_of
from tests.references.trajectory import first_difference

PRIOR = Prior(
    tip_m=(0.1, 0.2, 0.3),
    tip_std_m=0.4,
    azimuth_rad=0.5,
    azimuth_std_rad=0.6,
    elevation_rad=0.7,
    elevation_std_rad=0.8,
    spin_rad=0.9,
    spin_std_rad=1.1,
    velocity_std_m_s=1.2,
    angle_rate_std_rad_s=1.3,
    acceleration_std_m_s2=1.4,
    angle_acceleration_std_rad_s2=1.5,
)
TIP = {
    "tip_x_m": (0.1, 0.4, "m"),
    "tip_y_m": (0.2, 0.4, "m"),
    "tip_z_m": (0.3, 0.4, "m"),
}
VELOCITY = {f"tip_{axis}_velocity_m_s": (0.0, 1.2, "m/s") for axis in "xyz"}
ACCELERATION = {f"tip_{axis}_acceleration_m_s2": (0.0, 1.4, "m/s²") for axis in "xyz"}
BIASES = {
    "accel_bias_x_m_s2": (0.0, 1.6, "m/s²"),
    "accel_bias_y_m_s2": (0.0, 1.6, "m/s²"),
    "accel_bias_z_m_s2": (0.0, 1.6, "m/s²"),
    "gyro_bias_y_rad_s": (0.0, 1.7, "rad/s"),
}
EXPECTED = {
    5: {
        **TIP,
        "azimuth_rad": (0.5, 0.6, "rad"),
        "elevation_rad": (0.7, 0.8, "rad"),
        **VELOCITY,
        "azimuth_rate_rad_s": (0.0, 1.3, "rad/s"),
        "elevation_rate_rad_s": (0.0, 1.3, "rad/s"),
        **ACCELERATION,
        "azimuth_acceleration_rad_s2": (0.0, 1.5, "rad/s²"),
        "elevation_acceleration_rad_s2": (0.0, 1.5, "rad/s²"),
        **BIASES,
    },
    6: {
        **TIP,
        "mrp_x": (math.nan, math.nan, "1"),
        "mrp_y": (math.nan, math.nan, "1"),
        "mrp_z": (math.nan, math.nan, "1"),
        **VELOCITY,
        **{f"body_rate_{axis}_rad_s": (0.0, 1.3, "rad/s") for axis in "xyz"},
        **ACCELERATION,
        **{f"body_acceleration_{axis}_rad_s2": (0.0, 1.5, "rad/s²") for axis in "xyz"},
        **BIASES,
    },
}
"""State name → mean, standard deviation, unit, in the order of the state.

The attitude of six degrees of freedom has tests of its own.
"""


def config_of(degrees_of_freedom: int, **others: Any) -> PenConfig:
    sensors = {
        "accel": Accelerometer(**ACCELEROMETER, bias_std_m_s2=1.6),
        "gyro": Gyroscope(**GYROSCOPE, axes=("y",), bias_std_rad_s=1.7),
        "camera": PoseCamera(**CAMERA),
    }
    return pen(degrees_of_freedom, sensors, **{"prior": PRIOR, **others})


def model_of(degrees_of_freedom: int, **others: Any) -> StateSpaceModel:
    return pen_model(config_of(degrees_of_freedom, **others))


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_every_state_has_its_own_mean_and_spread(degrees_of_freedom: int) -> None:
    model, expected = model_of(degrees_of_freedom), EXPECTED[degrees_of_freedom]
    assert model.state_names == tuple(expected)
    mean, std, unit = (np.array(column) for column in zip(*expected.values(), strict=True))
    assert model.state_units == tuple(unit)
    own = np.isfinite(mean)
    assert np.array_equal(model.prior.mean[own], mean[own])
    assert model.prior.std[own] == pytest.approx(std[own], rel=1e-15)
    off_diagonal = model.prior.covariance - np.diag(np.diag(model.prior.covariance))
    off_diagonal[np.ix_(~own, ~own)] = 0.0
    assert not off_diagonal.any()


BOUNDED = TipBoundedVelocity(speed_m_s=0.08, correlation_time_s=0.1)


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize(
    ("tip", "sensors", "std"),
    [
        (BOUNDED, None, (1.2, 1.4)),
        (BOUNDED, ["accel", "gyro"], (0.08, 0.8)),
        (TipWhiteJerk(), ["accel", "gyro"], (1.2, 1.4)),
        (TipMatern(std_m=0.3, correlation_time_s=0.1), ["gyro"], (0.3 / 0.1 / 3**0.5, 0.3 / 0.01)),
    ],
    ids=["a camera", "bounded velocity", "white jerk", "Matérn"],
)
def test_without_a_camera_the_tip_starts_as_it_moves_for_ever(
    degrees_of_freedom: int, tip: TipMotion, sensors: list[str] | None, std: tuple[float, float]
) -> None:
    """Velocity and acceleration; the prior's where a camera sees them or the chain has none."""
    config = config_of(degrees_of_freedom, motion=Motion(tip=tip))
    model = pen_model(config, sensors)
    for names, expected in zip((VELOCITY, ACCELERATION), std, strict=True):
        found = [model.prior.std[model.state_names.index(name)] for name in names]
        assert found == pytest.approx([expected] * 3, rel=1e-14)


@pytest.mark.parametrize("tip", [BOUNDED, TipMatern(std_m=0.3, correlation_time_s=0.1)])
def test_a_stationary_start_stays_stationary(tip: TipMotion) -> None:
    """F P Fᵀ + G Gᵀ = P, whatever the step: of place too where a chain has one.

    Place and acceleration of a stationary motion have the covariance -var(velocity).
    """
    chain, dt = tip.built(), ca.SX.sym("dt")
    step = ca.Function("step", [dt], [chain.transition(dt), chain.factor(dt)])
    P = np.diag(np.square(chain.stationary_std))
    P[0, 2] = P[2, 0] = -P[1, 1]
    kept = slice(0 if np.isfinite(P[0, 0]) else 1, 3)
    for time in (1e-3, 0.01, 0.3):
        F, G = (part.full() for part in step(time))
        F, Q = F[kept, kept], (G @ G.T)[kept, kept]
        assert F @ P[kept, kept] @ F.T + Q == pytest.approx(P[kept, kept], rel=1e-11, abs=1e-12)


def attitude_part(**prior: float) -> Array:
    """Covariance (3, 3) of the first attitude in body axes; the model's go with its heading."""
    model = model_of(6, prior=Prior(**prior))
    R = Rotation.from_mrp(model.prior.mean[SIGMA].copy())
    M = (heading_of(R).inv() * R).as_matrix()
    return np.asarray(M.T @ model.prior.covariance[SIGMA, SIGMA] @ M)


def jacobian_by_scipy(azimuth: float, elevation: float, spin: float) -> Array:
    """Turns in body axes per change of each angle, by five-point differences."""
    at = np.array([azimuth, elevation, spin])
    R = body_to_world(*at[:, None])[0]

    def turned(k: int, step: float) -> Array:
        moved = at + step * np.eye(3)[k]
        return np.asarray((R.inv() * body_to_world(*moved[:, None])[0]).as_rotvec())

    columns = [first_difference(lambda h, k=k: turned(k, h), 0.0, 1e-3) for k in range(3)]  # type: ignore[misc]
    return np.column_stack(columns)


@pytest.mark.parametrize("seed", range(8))
def test_what_is_known_of_the_angles_is_known_of_the_attitude(seed: int) -> None:
    """J diag(σ²) Jᵀ, where the azimuth's part is no smaller than the rule for an upright pen."""
    rng = np.random.default_rng(seed)
    azimuth, elevation, spin = rng.uniform([-3, -0.9, -3], [3, 0.9, 3])
    std = rng.uniform(0.01, 0.3, 3)
    prior = {"azimuth_rad": azimuth, "elevation_rad": elevation, "spin_rad": spin}
    spread = dict(zip(("azimuth_std_rad", "elevation_std_rad", "spin_std_rad"), std, strict=True))
    J = jacobian_by_scipy(azimuth, elevation, spin)
    expected = J @ np.diag(std**2) @ J.T
    found = attitude_part(**prior, **spread)
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    mean = model_of(6, prior=Prior(**prior)).prior.mean[SIGMA].copy()
    away = body_to_world(*np.array([[azimuth], [elevation], [spin]]))[0].inv()
    assert (away * Rotation.from_mrp(mean)).magnitude() < 1e-14


@pytest.mark.parametrize("elevation", [np.pi / 2, -np.pi / 2])
@pytest.mark.parametrize("spin", [0.0, 0.9])
def test_the_tilt_of_an_upright_pen_is_isotropic(elevation: float, spin: float) -> None:
    """Nothing known of azimuth and spin: known alike about both level axes, positive definite."""
    P = attitude_part(elevation_rad=elevation, elevation_std_rad=0.2, spin_rad=spin)
    assert P[:2, :2] == pytest.approx(0.04 * np.eye(2), abs=1e-15)
    assert P[:2, 2] == pytest.approx(0, abs=1e-15)
    assert P[2, 2] > np.pi**2 / 3 - 1e-12
    np.linalg.cholesky(P)


def test_a_known_azimuth_stays_known() -> None:
    """The rule for upright pens adds nothing of note where the pen leans and azimuth is known."""
    leaning = {"elevation_rad": 0.6, "elevation_std_rad": 0.4, "azimuth_std_rad": 0.02}
    P, J = attitude_part(**leaning, spin_std_rad=0.1), jacobian_by_scipy(0.0, 0.6, 0.0)
    of_angles = np.linalg.inv(J) @ P @ np.linalg.inv(J).T
    assert np.sqrt(np.diag(of_angles)) == pytest.approx([0.02, 0.4, 0.1], rel=1e-8)


def test_angles_of_a_start_have_the_deviations_of_the_file() -> None:
    """What people read at the first instant is what the file says, where the pen leans."""
    model = model_of(6)
    assert model.outputs is not None
    x, d = ca.SX.sym("x", model.n_x), ca.SX.sym("d", model.n_x)
    moved = model.outputs.function(model.retract(x, d))
    at_zero = ca.substitute(ca.jacobian(moved, d), d, ca.SX.zeros(model.n_x))
    H = ca.Function("H", [x], [at_zero])(model.prior.mean).full()
    std = np.sqrt(np.diag(H @ model.prior.covariance @ H.T))
    for name, expected in (("azimuth_rad", 0.6), ("elevation_rad", 0.8), ("spin_rad", 1.1)):
        assert std[model.outputs.names.index(name)] == pytest.approx(expected, rel=1e-9)


def test_nothing_is_known_of_azimuth_and_spin_by_default() -> None:
    """A uniform angle on (-π, π] has the variance ∫ a² da / 2π = π²/3."""
    angles = np.linspace(-math.pi, math.pi, 100_001)
    spread = np.sqrt(np.mean(angles**2))
    prior = Prior()
    assert prior.azimuth_std_rad == pytest.approx(spread, rel=1e-4)
    assert prior.spin_std_rad == pytest.approx(spread, rel=1e-4)


def test_a_fixed_spin_turns_the_sensor_axes() -> None:
    """At rest x and y of gravity turn by the spin about the pen's axis, z stays."""
    x = np.zeros(19)
    x[4] = 0.7
    read = call(model_of(5).sensor("accel").h, x)
    sideways = -9.81 * np.cos(0.7)
    expected = [
        sideways * np.cos(FIXED_SPIN_RAD),
        -sideways * np.sin(FIXED_SPIN_RAD),
        9.81 * np.sin(0.7),
    ]
    assert read == pytest.approx(expected, rel=1e-14)
    spinning = np.zeros(22)
    spinning[:18] = still_state(0.7, spin=FIXED_SPIN_RAD)
    assert call(model_of(6).sensor("accel").h, spinning) == pytest.approx(read, rel=1e-14)
