"""What people read of a free pen: values and deviations against SciPy's rotations."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import estimation.native
from ekf_baseline.ekf import Ekf
from estimation.collect import collected
from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import run
from estimation.outputs import derived_outputs, output_jacobian, outputs_of
from estimation.recording import Recording
from estimation.status import Status
from models.arrays import Array
from models.gaussian import GaussianState
from models.outputs import UNIFORM_ANGLE_STD_RAD
from models.pen import pen_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate
from tests.linear_models import constant_acceleration_system
from tests.references.free_tangent import attitude_outputs, retracted

SENSORS, SIGMA, N_FREE = ("accel", "gyro"), slice(3, 6), 18
DERIVED = (
    *("azimuth_rad", "elevation_rad", "spin_rad"),
    *("attitude_w", "attitude_x", "attitude_y", "attitude_z"),
    *("tip_x_velocity_m_s", "tip_y_velocity_m_s", "tip_z_velocity_m_s"),
    *("tip_x_acceleration_m_s2", "tip_y_acceleration_m_s2", "tip_z_acceleration_m_s2"),
)
"""Outputs that are not a component of both state and tangent vector."""

CAPPED = ("azimuth_rad", "spin_rad")
NO_TURN = 1e-3
"""Step of the differences in the tangent space: rad, m/s, …"""


@cache
def model() -> StateSpaceModel:
    return pen_model("reference", SENSORS)


@cache
def recording() -> Recording:
    return simulate("reference", SENSORS, motion="handwriting", duration_s=0.4, seed=3)


def values_at(names: tuple[str, ...], x: Array) -> Array:
    """The derived outputs (k,) of a state, without CasADi."""
    shown = attitude_outputs(x)
    shown |= dict(zip(DERIVED[7:], [*x[6:9], *x[12:15]], strict=True))
    return np.array([shown[name] for name in names])


def deviations_at(names: tuple[str, ...], x: Array, P: Array, step: float = NO_TURN) -> Array:
    """Their standard deviations (k,): J by five-point differences along the tangent space."""

    def moved(amount: float, i: int) -> Array:
        away = values_at(names, retracted(x, amount * np.eye(len(x))[i])) - at
        circular = [name in CAPPED for name in names]
        away[circular] = np.angle(np.exp(1j * away[circular]))
        return away

    at, h = values_at(names, x), step
    J = np.stack(
        [
            (8 * (moved(h, i) - moved(-h, i)) - moved(2 * h, i) + moved(-2 * h, i)) / (12 * h)
            for i in range(len(x))
        ],
        axis=1,
    )
    std = np.sqrt(np.einsum("oi,ij,oj->o", J, P, J))
    cap = [np.pi / np.sqrt(3) if name in CAPPED else np.inf for name in names]
    return np.minimum(std, cap)


def assert_right(history: EstimateHistory) -> None:
    """Every step's values to rounding, deviations to that of the differences."""
    assert history.derived_names == DERIVED
    for k in range(len(history)):
        x, P = history.mean[k], history.covariance[k]
        expected = values_at(DERIVED, x)
        np.testing.assert_allclose(history.derived[k], expected, rtol=0, atol=1e-13)
        std = deviations_at(DERIVED, x, P)
        np.testing.assert_allclose(history.derived_std[k], std, rtol=1e-8)


@pytest.mark.parametrize("estimator", ["ekf", "mhe-rti"])
def test_the_compiled_loop_says_what_scipy_says(estimator: str) -> None:
    history = run(create_estimator(estimator, model()), recording(), covariances=True)
    assert_right(history)


def test_the_interpreted_loop_says_what_scipy_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(estimation.native, "compiler", lambda: None)
    assert_right(run(Ekf(model()), recording(), covariances=True))


def test_steps_one_by_one_say_the_same() -> None:
    """What each estimate says, and what is collected of estimates that say nothing of it."""
    ekf = Ekf(model())
    state, estimates = ekf.init(), list[Estimate]()
    for measurement in recording().measurements(model()):
        state, estimate = ekf.step(state, measurement)
        estimates.append(estimate)
    silent = [dataclasses.replace(e, derived=None, derived_std=None) for e in estimates]
    history = collected("ekf", model(), silent, [0.0] * len(silent), covariances=True)
    assert_right(history)
    for k, estimate in enumerate(estimates):
        np.testing.assert_allclose(history.derived[k], estimate.derived, rtol=0, atol=1e-13)
        np.testing.assert_allclose(history.derived_std[k], estimate.derived_std, rtol=1e-12)


def random_covariance(rng: np.random.Generator, n: int, scale: float) -> Array:
    L = scale * rng.normal(size=(n, n))
    return np.asarray(L @ L.T)


@pytest.mark.parametrize("seed", range(8))
def test_any_attitude_with_any_covariance(seed: int) -> None:
    """Upside down, too, and beyond the shadow switch."""
    rng, n_x = np.random.default_rng(seed), model().n_x
    x, P = rng.normal(size=n_x), random_covariance(rng, n_x, 0.01)
    x[SIGMA] = Rotation.random(rng=rng).as_mrp()
    values, std = derived_outputs(model()).values(x[None], P[None])
    np.testing.assert_allclose(values[0], values_at(DERIVED, x), rtol=0, atol=1e-13)
    np.testing.assert_allclose(std[0], deviations_at(DERIVED, x, P), rtol=1e-7)


def pen_at(elevation: float, azimuth: float = 0.4, spin: float = -0.7) -> Array:
    x = np.zeros(model().n_x)
    x[SIGMA] = Rotation.from_euler("ZYZ", [azimuth, np.pi / 2 - elevation, spin]).as_mrp()
    return x


def test_an_angle_on_the_circle_is_never_less_known_than_unknown() -> None:
    names, x = derived_outputs(model()).names, pen_at(0.9)
    P = 100.0 * np.eye(model().n_x)
    _, std = derived_outputs(model()).values(x[None], P[None])
    of = dict(zip(names, std[0], strict=True))
    assert pytest.approx(np.pi / np.sqrt(3), rel=1e-15) == UNIFORM_ANGLE_STD_RAD
    for name in CAPPED:
        assert of[name] == UNIFORM_ANGLE_STD_RAD
    assert of["elevation_rad"] == pytest.approx(10.0, rel=1e-12)  # it is not on the circle


@pytest.mark.parametrize("side", [1, -1])
def test_near_upright_azimuth_and_spin_are_less_and_less_known(side: int) -> None:
    """A tilt of σ moves the azimuth by σ / cosθ, and the spin by σ tanθ; elevation by σ."""
    sigma = 1e-4
    P = sigma**2 * np.eye(model().n_x)
    for lean in (0.5, 0.1, 0.03, 0.01, 1e-3):
        x = pen_at(side * (np.pi / 2 - lean))
        values, std = derived_outputs(model()).values(x[None], P[None])
        of = dict(zip(DERIVED, std[0], strict=True))
        cos, sin = np.sin(lean), np.cos(lean)
        assert of["elevation_rad"] == pytest.approx(sigma, rel=1e-9)
        assert of["azimuth_rad"] == pytest.approx(sigma / cos, rel=1e-9)
        assert of["spin_rad"] == pytest.approx(sigma * np.hypot(1, sin / cos), rel=1e-9)
        assert dict(zip(DERIVED, values[0], strict=True))["azimuth_rad"] == pytest.approx(0.4)


@pytest.mark.parametrize("side", [1, -1])
def test_exactly_upright_everything_is_a_number(side: int) -> None:
    x, n_x = pen_at(side * np.pi / 2), model().n_x
    x[SIGMA] = [0, 0, 0.3] if side == 1 else [1, 0, 0]
    P = 1e-4 * np.eye(n_x)
    values, std = derived_outputs(model()).values(x[None], P[None])
    value, of = (dict(zip(DERIVED, rows[0], strict=True)) for rows in (values, std))
    assert np.isfinite(values).all()
    assert np.isfinite(std).all()
    assert value["elevation_rad"] == pytest.approx(side * np.pi / 2, abs=1e-7)
    assert of["azimuth_rad"] == of["spin_rad"] == UNIFORM_ANGLE_STD_RAD
    assert of["elevation_rad"] == pytest.approx(0.01, rel=1e-6)
    assert np.isfinite(output_jacobian(model())(x).full()).all()


@pytest.mark.parametrize("estimator", ["ekf", "mhe-rti"])
def test_an_upright_pen_says_that_it_is_near_singular(estimator: str) -> None:
    """Started upright and held so: every number is there, and the remark with each."""
    prior = GaussianState(np.zeros(model().n_x), model().prior.covariance)
    times = 0.01 * np.arange(30)
    still = np.zeros(model().n_x)
    readings = {sensor.name: sensor.h(still).full().ravel() for sensor in model().measured_sensors}
    held = Recording("upright", times, {k: np.tile(y, (30, 1)) for k, y in readings.items()})
    history = run(create_estimator(estimator, model()), held, prior=prior)
    assert all(Status.NEAR_SINGULAR in status for status in history.status)
    assert np.isfinite(history.values).all()
    assert np.isfinite(history.values_std).all()
    away = run(create_estimator(estimator, model()), recording())
    assert not any(Status.NEAR_SINGULAR in status for status in away.status)


def test_outputs_are_states_but_for_the_attitude() -> None:
    outputs = outputs_of(model())
    hidden = {"mrp_x", "mrp_y", "mrp_z"}
    assert set(model().state_names) - set(outputs.names) == hidden
    assert set(outputs.names) - set(model().state_names) == set(DERIVED[:7])
    circular = {n for n, w in zip(outputs.names, outputs.wrapped, strict=True) if w}
    assert circular == set(CAPPED)


def test_a_model_without_outputs_is_read_by_its_states() -> None:
    own = constant_acceleration_system(1).model
    assert outputs_of(own).names == own.state_names
    assert derived_outputs(own).names == ()
    np.testing.assert_array_equal(output_jacobian(own)(np.zeros(own.n_x)).full(), np.eye(own.n_x))
