"""The unscented Kalman filter against a textbook's, on manifolds, and out of order."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from ekf_baseline.ukf import Ukf, UkfConfig
from ekf_baseline.unscented import Spread, root
from estimation.estimator import run_measurements
from estimation.recording import Measurement
from estimation.status import Status
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate
from tests.ekf_baseline.arrivals import STREAMS, in_order, out_of_order
from tests.engines import needs_compiler
from tests.references import unscented

SPREADS = ((1.0, 2.0, 0.0), (0.1, 2.0, 0.0), (0.5, 0.25, 1.0))
NOISE = 0.05
STEP_S = 0.1


def transition(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
    """A Van der Pol oscillator of unknown damping, whose noise enters by a product."""
    pull = x[2] * (1 - x[0] ** 2) * x[1] - x[0]
    return ca.vertcat(x[0] + dt * x[1] * (1 + 0.3 * w[0]), x[1] + dt * (pull + w[1]), x[2])


def reading(x: ca.SX) -> ca.SX:
    return ca.vertcat(x[0], x[0] * x[1])


def oscillator() -> StateSpaceModel:
    states = {"x": (1.0, 0.3), "v": (0.0, 0.3), "mu": (0.6, 0.3)}
    sensors = {"level": OwnSensor(reading, {"a": "", "b": ""}, NOISE, 10.0)}
    return own_model("oscillator", states, transition, 2, sensors)


def as_numbers(function: Callable[..., ca.SX], *sizes: int) -> Callable[..., Array]:
    symbols = [ca.SX.sym(f"s{i}", n) for i, n in enumerate(sizes)]
    made = ca.Function("made", symbols, [function(*symbols)])
    return lambda *values: np.array(made(*values)).ravel()


@pytest.mark.parametrize("told", SPREADS)
def test_it_is_the_textbooks_filter(told: tuple[float, float, float]) -> None:
    model, rng = oscillator(), np.random.default_rng(3)
    f, h = as_numbers(transition, 3, 2, 1), as_numbers(reading, 3)
    x = np.array([1.2, 0.2, 1.0])
    measurements = []
    for k in range(30):
        x = f(x, 0.3 * rng.standard_normal(2), STEP_S) if k else x
        measurements.append(Measurement(STEP_S * k, h(x) + NOISE * rng.standard_normal(2)))
    alpha, beta, kappa = told
    filter_ = Ukf(model, UkfConfig(alpha=alpha, beta=beta, kappa=kappa))
    history = run_measurements(filter_, measurements, covariances=True)
    moments, R = (model.prior.mean, model.prior.covariance), NOISE**2 * np.eye(2)
    for k, measurement in enumerate(measurements):
        if k:
            moments = unscented.predict(moments, lambda x, w: f(x, w, STEP_S), 2, told)
        moments = unscented.update(moments, measurement.y, h, R, told)
        np.testing.assert_allclose(history.mean[k], moments[0], rtol=0, atol=1e-10)
        np.testing.assert_allclose(history.covariance[k], moments[1], rtol=1e-8, atol=1e-12)
    ekf = run_measurements(Ekf(model), measurements)
    assert np.abs(ekf.mean - history.mean).max() > 1e-3  # the problem tells them apart


@pytest.mark.parametrize("n", [1, 4, 30])
def test_the_transform_is_exact_for_a_quadratic(n: int) -> None:
    """Of g(x) = xᵀ A x with x ~ N(0, I) the mean is tr A, for every spread."""
    A = np.random.default_rng(n).standard_normal((n, n))
    for told in SPREADS:
        spread = Spread.of(n, *told)
        points = spread.points(np.eye(n))
        apart = np.einsum("im,ij,jm->m", points, A, points)[None]
        np.testing.assert_allclose(spread.mean(apart), [np.trace(A)], rtol=1e-10, atol=1e-10)


def test_a_root_of_what_is_singular() -> None:
    A = np.random.default_rng(0).standard_normal((4, 2)) * np.array([[1e6], [1], [1e-4], [1]])
    P = A @ A.T
    L = root(P)
    size = np.sqrt(np.diag(P))
    np.testing.assert_allclose((L @ L.T - P) / np.outer(size, size), 0, atol=1e-12)


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("name", ["pen", "inputs", "at rest"])
def test_late_measurements_are_a_run_in_order(name: str) -> None:
    stream = STREAMS[name]()
    some = out_of_order(stream, seed=1, late_s=0.09)[:60]
    filter_ = Ukf(stream.model, UkfConfig(late_samples=40))
    state, late = filter_.init(), 0
    for k, measurement in enumerate(some, 1):
        late += state.time_s is not None and measurement.time_s < state.time_s
        state, estimate = filter_.step(state, measurement)
        assert Status.LATE not in estimate.status
        if k % 10 == 0:
            wanted = run_measurements(filter_, in_order(stream.model, some[:k]), covariances=True)
            np.testing.assert_array_equal(estimate.state.mean, wanted.mean[-1])
            np.testing.assert_array_equal(estimate.state.covariance, wanted.covariance[-1])
            assert estimate.time_s == wanted.time_s[-1]
    assert late > 5


def test_what_is_too_late_is_said() -> None:
    filter_ = Ukf(oscillator(), UkfConfig(late_samples=0))
    state = filter_.init()
    for time_s in (0.0, 0.1):
        state, _ = filter_.step(state, Measurement(time_s, np.array([1.0, 0.0])))
    after, estimate = filter_.step(state, Measurement(0.05, np.array([1.0, 0.0])))
    assert Status.LATE in estimate.status
    assert after is state


@needs_compiler
def test_compiled_is_interpreted(interpreted_model: Callable[[StateSpaceModel], Ukf]) -> None:
    model = oscillator()
    measurements = [Measurement(STEP_S * k, np.array([1.0, 0.1])) for k in range(5)]
    one = run_measurements(Ukf(model), measurements).mean
    other = run_measurements(interpreted_model(model), measurements).mean
    np.testing.assert_array_equal(one, other)


@pytest.fixture
def interpreted_model(
    monkeypatch: pytest.MonkeyPatch,
) -> Callable[[StateSpaceModel], Ukf]:
    def made(model: StateSpaceModel) -> Ukf:
        monkeypatch.setattr("estimation.native.compiler", lambda: None)
        return Ukf(model)

    return made


@pytest.mark.usefixtures("interpreted")
def test_on_a_pen_it_is_as_right_as_an_ekf() -> None:
    pen, sensors = load_pen("reference"), ("accel", "gyro", "camera")
    recording = simulate(pen, sensors, motion="handwriting", duration_s=1.2, seed=4)
    assert recording.truth is not None
    model, rms = pen_model(pen, sensors), {}
    for filter_ in (Ekf(model), Ukf(model)):
        history = run_measurements(filter_, recording.measurements(model))
        late = history.time_s > 0.7
        errors = history.errors(recording.truth)[late][:, history.index("tip_x_m")]
        rms[filter_.name] = float(np.sqrt((errors**2).mean()))
        assert history.solved_fraction == 1.0
    assert rms["ukf"] < 1.2 * rms["ekf"] + 1e-4


def test_a_prior_that_is_nearly_known() -> None:
    """Deviations of 1e-9 beside one of 1: no point is lost to rounding."""
    model = oscillator()
    known = GaussianState(model.prior.mean, np.diag([1e-18, 1.0, 1e-18]))
    filter_ = Ukf(model)
    state = filter_.init(known)
    for k in range(3):
        state, estimate = filter_.step(state, Measurement(STEP_S * k, np.array([1.0, 0.2])))
    assert estimate.status.is_solved
    assert (np.linalg.eigvalsh(estimate.state.covariance) > 0).all()


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"alpha": 0.0}, "alpha is 0.0, expected a positive number"),
        ({"alpha": 1.5}, "beta is 2.0, expected alpha² = 2.25 or more"),
        ({"kappa": -1.0}, "kappa is -1.0, expected 0 or more"),
        ({"late_samples": -1}, "late_samples is -1, expected a whole number from 0"),
    ],
)
def test_settings_that_cannot_be(settings: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        UkfConfig(**settings)  # type: ignore[arg-type]
