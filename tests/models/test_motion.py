"""The motion of a pen file: each chain is one of `models.chains`, in the model too."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.arrays import Array
from models.chains import Chain, bounded_velocity, matern, white_jerk
from models.free_pen import ALPHA, N_FREE, OMEGA, SIGMA, TIP, A, V
from models.motion import (
    AttitudeBoundedRate,
    AttitudeMotion,
    AttitudeWhiteJerk,
    Motion,
    TipBoundedVelocity,
    TipMatern,
    TipMotion,
    TipWhiteJerk,
)
from models.pen import pen_model
from models.sensor_kinds.accelerometer import Accelerometer
from models.simulation import drawn_states
from models.state_space import StateSpaceModel
from tests.models.pens import ACCELEROMETER, call, pen, random_state
from tests.references.free_tangent import heading_of

CENTRE = (0.1, -0.2, 0.03)
DT = 0.03
TIPS: dict[str, tuple[TipMotion, Chain]] = {
    "white jerk": (TipWhiteJerk(jerk_density_m_s3_per_sqrt_hz=7.0), white_jerk(7.0)),
    "bounded velocity": (
        TipBoundedVelocity(speed_m_s=0.2, correlation_time_s=0.4),
        bounded_velocity(0.2, 0.4),
    ),
    "Matérn": (TipMatern(std_m=0.05, correlation_time_s=0.3), matern(0.05, 0.3)),
    "Matérn about a place": (
        TipMatern(std_m=0.05, correlation_time_s=0.3, centre_m=CENTRE),
        matern(0.05, 0.3),
    ),
}
ATTITUDES: dict[str, tuple[AttitudeMotion, Chain]] = {
    "white jerk": (AttitudeWhiteJerk(jerk_density_rad_s3_per_sqrt_hz=30.0), white_jerk(30.0)),
    "bounded rate": (
        AttitudeBoundedRate(rate_rad_s=3.0, correlation_time_s=0.2),
        bounded_velocity(3.0, 0.2),
    ),
}


def model_of(degrees_of_freedom: int, **parts: TipMotion | AttitudeMotion) -> StateSpaceModel:
    sensors = {"accel": Accelerometer(**ACCELEROMETER)}
    motion = Motion.model_validate(parts)
    return pen_model(pen(degrees_of_freedom, sensors, motion=motion), writing_area=False)


def numbers(chain: Chain) -> tuple[Array, Array]:
    dt = ca.SX.sym("dt")
    F, G = ca.Function("step", [dt], [chain.transition(dt), chain.factor(dt)])(DT)
    return F.full(), G.full()


def rows(degrees_of_freedom: int, axis: int) -> list[int]:
    """Place, velocity and acceleration of the tip along an axis."""
    n_q = degrees_of_freedom
    return [axis, axis + n_q, axis + 2 * n_q]


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("name", TIPS)
def test_the_tip_moves_as_its_chain(name: str, degrees_of_freedom: int) -> None:
    """About its centre, along every axis alike."""
    config, chain = TIPS[name]
    model, rng = model_of(degrees_of_freedom, tip=config), np.random.default_rng(1)
    x, w = random_state(rng, degrees_of_freedom), rng.standard_normal(model.n_w)
    moved, (F, G) = call(model.f, x, w, DT), numbers(chain)
    if degrees_of_freedom == 6:  # its noise goes with the heading
        N = heading_of(Rotation.from_mrp(x[SIGMA]))
        for part in (slice(0, 3), slice(6, 9), slice(12, 15)):
            w[part] = N.apply(w[part])
    for axis in range(3):
        of_axis = rows(degrees_of_freedom, axis)
        centre = np.array([config.centre_m[axis], 0.0, 0.0])
        expected = centre + F @ (x[of_axis] - centre) + G @ w[of_axis]
        assert moved[of_axis] == pytest.approx(expected, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("name", ATTITUDES)
def test_rates_move_as_their_chain(name: str) -> None:
    config, chain = ATTITUDES[name]
    model, rng = model_of(6, attitude=config), np.random.default_rng(2)
    x, w = random_state(rng, 6), rng.standard_normal(model.n_w)
    moved, (F, G) = call(model.f, x, w, DT), numbers(chain)
    for axis in range(3):
        of_axis = [part.start + axis for part in (SIGMA, OMEGA, ALPHA)]
        noise = G @ w[of_axis]
        expected = F[1:, 1:] @ x[of_axis[1:]] + noise[1:]
        assert moved[of_axis[1:]] == pytest.approx(expected, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("name", ATTITUDES)
def test_angles_move_as_their_chain_without_spin(name: str) -> None:
    config, chain = ATTITUDES[name]
    model, rng = model_of(5, attitude=config), np.random.default_rng(3)
    x, w = random_state(rng, 5), rng.standard_normal(model.n_w)
    moved, (F, G) = call(model.f, x, w, DT), numbers(chain)
    for angle in (3, 4):
        of_angle = rows(5, angle)
        expected = F @ x[of_angle] + G @ w[of_angle]
        assert moved[of_angle] == pytest.approx(expected, rel=1e-12, abs=1e-14)


def test_a_tip_with_a_centre_stays_near_it() -> None:
    """Drawn for 400 correlation times: mean, spread and speed of its stationary law.

    Samples two correlation times apart are nearly independent (correlation 0.5 e⁻² (…) < 0.4):
    the limits are four standard errors of half as many.
    """
    std, time = 0.05, 0.3
    config = TipMatern(std_m=std, correlation_time_s=time, centre_m=CENTRE)
    model = model_of(6, tip=config)
    model = model.replace(prior=model.prior.__class__(model.prior.mean, 1e-6 * np.eye(N_FREE)))
    time_s = np.arange(4000) * time / 5
    states = drawn_states(model, time_s, np.random.default_rng(5))[100:]
    n = len(states) / 20
    away = states[:, TIP] - np.array(CENTRE)
    assert np.abs(away.mean(axis=0)).max() < 4 * std / np.sqrt(n)
    assert np.abs(away.std(axis=0) / std - 1).max() < 4 / np.sqrt(2 * n)
    speed = std / time / np.sqrt(3)
    assert np.abs(states[:, V].std(axis=0) / speed - 1).max() < 4 / np.sqrt(2 * n)
    assert np.abs(away).max() < 5.5 * std


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_a_hand_is_the_default(degrees_of_freedom: int) -> None:
    """Its tip gets neither fast nor far in a second, and forgets what moved it."""
    model = model_of(degrees_of_freedom)
    F, G = numbers(bounded_velocity(0.5, 0.15))
    x = np.zeros(model.n_x)
    of_axis = rows(degrees_of_freedom, 0)
    x[of_axis] = [0.0, 0.3, 1.5]
    moved = call(model.f, x, np.zeros(model.n_w), DT)
    assert moved[of_axis] == pytest.approx(F @ x[of_axis], rel=1e-12)
    noisy = call(model.f, 0 * x, np.ones(model.n_w), DT)
    assert noisy[of_axis] == pytest.approx(G @ np.ones(3), rel=1e-12)
    assert call(model.f, x, np.zeros(model.n_w), 20.0)[A if degrees_of_freedom == 6 else 10] == (
        pytest.approx(0, abs=1e-12)
    )
