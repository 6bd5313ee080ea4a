"""However much better a reading is than what was known: deviations are right, or it is said."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import pen_mhe as pm
from ekf_baseline.ekf import Ekf
from estimation import interpreted_stage
from estimation.derivatives import Derivatives
from estimation.estimate import Estimate
from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from estimation.square_roots import LOST, RootUpdate
from estimation.status import Status
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.linear_models import constant_acceleration_system
from tests.references import exact_filter

pytestmark = needs_compiler

NOISE, STEP_S, N_STEPS = 1e-3, 0.25, 8
RATIOS = {1e4: 1e-6, 1e10: 1e-6, 1e13: 1e-2, 1e16: 1e-2}
"""Variance of the prior over that of the noise → how far a deviation may be off, relative."""
ESTIMATORS: dict[str, Callable[[StateSpaceModel], Any]] = {
    "ekf": Ekf,
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=4)),
    "mhe": lambda model: Mhe(model, MheConfig(horizon=4)),
}


def chain(ratio: float, density: float = 1e-6) -> StateSpaceModel:
    """Position, velocity and acceleration of which nothing is known, and a very good position."""
    model = constant_acceleration_system(1, density).model
    position = replace(model.sensors[0], noise_std=np.array([NOISE]))
    prior = GaussianState(np.zeros(3), ratio * NOISE**2 * np.eye(3))
    return model.replace(sensors=(position,), prior=prior)


def readings(n: int = N_STEPS) -> list[Measurement]:
    return [Measurement(k * STEP_S, np.array([0.1 * k])) for k in range(n)]


def exact_deviations(model: StateSpaceModel, n: int = N_STEPS) -> list[Array]:
    """Of every step, in rational arithmetic."""
    at, found = Derivatives(model), []
    F, G = at.of_step(model.prior.mean, STEP_S)
    H = at.of_readings(model.prior.mean, np.zeros(1))
    P = exact_filter.exact(model.prior.covariance)
    for k in range(n):
        P = exact_filter.predicted(P, F, G) if k else P
        P = exact_filter.updated(P, H, [NOISE])
        found.append(exact_filter.deviations(P))
    return found


def furthest(estimates: Sequence[Estimate], wanted: Sequence[Array]) -> float:
    return max(
        float(np.abs(e.state.std / std - 1).max()) for e, std in zip(estimates, wanted, strict=True)
    )


@pytest.mark.cover
@pytest.mark.parametrize("name", ESTIMATORS)
@pytest.mark.parametrize("ratio", RATIOS)
def test_a_chain_against_rational_arithmetic(ratio: float, name: str) -> None:
    model = chain(ratio)
    wanted = exact_deviations(model)
    for engine in compiled_and_interpreted(lambda: ESTIMATORS[name](model)):
        estimates = steps(engine, readings())
        assert furthest(estimates, wanted) < RATIOS[ratio]
        assert not any(Status.DIGITS_LOST in e.status for e in estimates)


def test_a_difference_of_covariances_has_no_such_digits() -> None:
    """The test's own test: the plain P - W Wᵀ, in the same arithmetic."""
    model = chain(1e16)
    F, G = Derivatives(model).of_step(model.prior.mean, STEP_S)
    P, h, found = model.prior.covariance, np.array([1.0, 0, 0]), []
    with np.errstate(invalid="ignore"):
        for k in range(N_STEPS):
            P = F @ P @ F.T + G @ G.T if k else P
            W = P @ h / np.sqrt(h @ P @ h + NOISE**2)
            P = P - np.outer(W, W)
            found.append(np.sqrt(np.diag(P)))
    off = np.abs(np.array(found) / np.array(exact_deviations(model)) - 1)
    assert not off.max() < 0.5


@pytest.mark.parametrize("name", ESTIMATORS)
def test_beyond_all_digits_it_says_so(name: str) -> None:
    model = chain(1e30)
    for engine in compiled_and_interpreted(lambda: ESTIMATORS[name](model)):
        estimates = steps(engine, readings())
        assert Status.DIGITS_LOST in estimates[0].status
        assert estimates[0].status.is_solved
        for estimate in estimates:
            assert np.isfinite(estimate.state.mean).all()
            assert (estimate.state.std > 0).all()


@pytest.mark.parametrize("side", [0.5, 2.0])
def test_on_either_side_of_the_bound_both_forms_agree(
    side: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Just below it a stage is made of covariances, just above it of roots."""
    model, made = chain(side * LOST), []
    plain = interpreted_stage.updated_root

    def counted(*arguments: Any) -> RootUpdate:
        made.append(1)
        return plain(*arguments)

    monkeypatch.setattr(interpreted_stage, "updated_root", counted)
    wanted = exact_deviations(model)
    for ekf in compiled_and_interpreted(lambda: Ekf(model)):
        _, estimate = ekf.step(ekf.init(), readings(1)[0])
        np.testing.assert_allclose(estimate.state.std, wanted[0], rtol=1e-9)
    assert bool(made) == (side > 1)


@pytest.mark.parametrize("sensors", [["accel", "gyro"], ["accel", "gyro", "camera"]])
def test_a_pen_needs_roots_at_its_first_sample_at_most(
    sensors: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = pm.simulate("reference", sensors, motion="handwriting", duration_s=1.0)
    model, made = pm.pen_model("reference", sensors), []
    plain = interpreted_stage.updated_root

    def counted(*arguments: Any) -> RootUpdate:
        made.append(1)
        return plain(*arguments)

    monkeypatch.setattr(interpreted_stage, "updated_root", counted)
    _, ekf = compiled_and_interpreted(lambda: Ekf(model))
    state, counts = ekf.init(), []
    for measurement in recording.measurements(model):
        state, _ = ekf.step(state, measurement)
        counts.append(len(made))
        assert state.gaussian.root is None
    assert counts[-1] == counts[0]


def test_a_root_is_kept_until_a_covariance_has_its_digits_again() -> None:
    model = chain(1e12, density=1.0)
    ekf = Ekf(model)
    state, forms = ekf.init(), []
    for measurement in readings(40):
        state, _ = ekf.step(state, measurement)
        forms.append(state.gaussian.root is not None)
    assert any(forms[:4])
    assert not any(forms[10:])


@pytest.mark.parametrize(("ratio", "tolerance"), [(1e4, 1e-8), (1e10, 1e-6), (1e16, 1e-2)])
def test_a_linearised_free_pen_against_sixty_digits(ratio: float, tolerance: float) -> None:
    """F, G and H along a path, as floating point has them; what is made of them has 60 digits."""
    sensors = ["accel", "gyro", "camera"]
    recording = pm.simulate("reference", sensors, motion="turn", duration_s=0.06)
    model = pm.pen_model("reference", sensors)
    measurements = list(recording.measurements(model))
    points = [estimate.state.mean for estimate in steps(Ekf(model), measurements)]
    stage, at = KalmanStage(model), Derivatives(model)
    noise_std, number = model.noise_std, exact_filter.sixty_digits
    prior = GaussianState(points[0], ratio * noise_std.min() ** 2 * np.eye(model.n_x))
    with exact_filter.long_decimals():
        P = exact_filter.exact(prior.covariance, number)
        gaussian = prior
        for k, measurement in enumerate(measurements):
            if k:
                dt = measurement.time_s - measurements[k - 1].time_s
                F, G = at.of_step(points[k - 1], dt)
                P = exact_filter.predicted(P, F, G, number)
                gaussian = stage.predict(gaussian, dt, points[k - 1]).state
            update = stage.update(gaussian, measurement.y, x_lin=points[k])
            there = update.present
            P = exact_filter.updated(P, update.H[there], noise_std[there].tolist(), number)
            gaussian = update.state
            np.testing.assert_allclose(gaussian.std, exact_filter.deviations(P), rtol=tolerance)
