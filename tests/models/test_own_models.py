"""A model of one's own: plain functions of symbols in, a state-space model out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
import numpy as np
import pytest

from estimation.estimator import run
from estimation.recording import Measurement, Recording
from estimation.status import Status
from models.arrays import Array
from models.errors import InputError
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import ESTIMATORS, LEAST_SQUARES, create_estimator, settings_read
from recordings.simulate_pen import simulate_model
from tests.references import kalman

pytestmark = pytest.mark.usefixtures("interpreted")

STATES = {"distance_m": (0.3, 0.5), "speed_m_s": (-0.2, 0.4)}
RULER_STD, SPEEDOMETER_STD, DENSITY = 0.02, 0.05, 0.8
RULER_HZ, SPEEDOMETER_HZ = 10.0, 40.0


def cart(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
    """White acceleration of density 0.8, exactly: two unit noises per step."""
    distance = x[0] + dt * x[1] + DENSITY * dt * ca.sqrt(dt / 12) * (ca.sqrt(3) * w[0] + w[1])
    return ca.vertcat(distance, x[1] + DENSITY * ca.sqrt(dt) * w[0])


def ruler(**changes: Any) -> OwnSensor:
    of_distance = {"reads": lambda x: x[0], "axes": {"x": "m"}, "noise_std": RULER_STD}
    return OwnSensor(**{**of_distance, "rate_hz": RULER_HZ, **changes})


def speedometer() -> OwnSensor:
    """Two rows: the speed, and the speed in other words."""
    return OwnSensor(
        lambda x: ca.vertcat(x[1], -2 * x[1]),
        {"forward": "m/s", "twice back": "m/s"},
        SPEEDOMETER_STD,
        SPEEDOMETER_HZ,
    )


def cart_model(
    states: Mapping[str, Any] = STATES,
    transition: Callable[[ca.SX, ca.SX, ca.SX], ca.SX] = cart,
    **sensors: OwnSensor,
) -> StateSpaceModel:
    chosen = sensors or {"ruler": ruler(), "speedometer": speedometer()}
    return own_model("cart", states, transition, 2, chosen)


def F(dt: float) -> Array:
    return np.array([[1.0, dt], [0.0, 1.0]])


def Q(dt: float) -> Array:
    return DENSITY**2 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])


H = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, -2.0]])
R = np.diag([RULER_STD**2, SPEEDOMETER_STD**2, SPEEDOMETER_STD**2])


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate_model(cart_model(), duration_s=1.5, seed=4)


def test_what_was_said_is_in_the_model() -> None:
    model = cart_model()
    assert model.name == "cart"
    assert model.state_names == ("distance_m", "speed_m_s")
    assert model.state_units == ("m", "m/s")
    np.testing.assert_array_equal(model.prior.mean, [0.3, -0.2])
    np.testing.assert_allclose(model.prior.std, [0.5, 0.4], rtol=1e-15)
    assert (model.n_w, model.n_y, model.n_r) == (2, 3, 3)
    assert model.reading_names == ("ruler_x", "speedometer_forward", "speedometer_twice back")
    assert model.sensors[1].unit_of_axis == ("m/s", "m/s")
    np.testing.assert_array_equal(model.noise_std, [RULER_STD, SPEEDOMETER_STD, SPEEDOMETER_STD])
    assert "ruler (own, 10 Hz)" in repr(model)


def test_nothing_else_limits_it() -> None:
    """No bound, no inequality, no singular attitude, no angle that wraps."""
    model = cart_model()
    assert not np.isfinite([model.lower, model.upper]).any()
    assert model.inequality.numel_out(0) == 0
    assert float(model.regularity([1e6, -1e6])) == 1
    far = np.array([100.0, -50.0])
    np.testing.assert_array_equal(model.retract(far, far).full().ravel(), 2 * far)
    np.testing.assert_array_equal(model.difference(far, -far).full().ravel(), 2 * far)


def test_every_sensor_reads_at_its_own_rate(recording: Recording) -> None:
    for name, rate_hz, width in (("ruler", RULER_HZ, 1), ("speedometer", SPEEDOMETER_HZ, 2)):
        times, values = recording.sensor(name)
        np.testing.assert_allclose(times, np.arange(int(1.5 * rate_hz) + 1) / rate_hz, atol=1e-9)
        assert values.shape == (len(times), width)
    # Every fourth reading of one falls together with one of the other.
    assert len(recording.time_s) == 61


def test_readings_are_the_truth_with_the_stated_noise() -> None:
    model = cart_model()
    long = simulate_model(model, duration_s=40.0, seed=5)
    assert long.truth is not None
    for sensor, rows in zip(model.sensors, (H[:1], H[1:]), strict=True):
        times, values = long.sensor(sensor.name)
        states = long.truth.states(model.state_names, times)
        squared = ((values - states @ rows.T) / sensor.noise_std) ** 2
        # Standard error of a variance from n samples: √(2/n); 4 of them, fixed seed.
        assert abs(squared.mean() - 1) < 4 * np.sqrt(2 / squared.size)


@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_every_estimator_is_the_kalman_filter(recording: Recording, name: str) -> None:
    """Instants of one sensor alone and of both; all in standard deviations."""
    model = cart_model()
    settings = {"horizon": 7}
    history = run(
        create_estimator(name, model, **settings_read(name, settings)), recording, covariances=True
    )
    assert set(history.status) == {Status.SOLVED}
    readings = [measurement.y for measurement in recording.measurements(model)]
    prior = model.prior.mean, model.prior.covariance
    rows_seen = set()
    for k, wanted in enumerate(kalman.run(prior, history.time_s, readings, F, Q, H, R)):
        x, P = wanted.mean, wanted.covariance
        std = np.sqrt(np.diag(P))
        assert np.abs((history.mean[k] - x) / std).max() < 1e-9
        assert np.abs((history.covariance[k] - P) / np.outer(std, std)).max() < 1e-9
        deviation = np.sqrt(np.diag(wanted.innovation_covariance))
        innovation = history.innovation[k][wanted.rows]
        assert np.abs((innovation - wanted.innovation) / deviation).max() < 1e-9
        rows_seen.add(tuple(wanted.rows))
    assert rows_seen == {(0, 1, 2), (1, 2)}


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_model_without_noise_is_a_model(name: str) -> None:
    """Nothing moves a constant: n readings leave its std at 1 / √(1/p² + n/r²)."""
    sensors = {"ruler": ruler()}
    model = own_model("constant", {"length_m": (0.0, 1.0)}, lambda x, w, dt: x, 0, sensors)
    recording = simulate_model(model, duration_s=1.0, seed=6)
    settings = {"horizon": 3}
    history = run(create_estimator(name, model, **settings_read(name, settings)), recording)
    assert recording.truth is not None
    assert np.ptp(recording.truth.values) == 0
    y, n = recording.sensor("ruler")[1][:, 0], 1 + np.arange(11)
    precision = 1 + n / RULER_STD**2
    np.testing.assert_allclose(history.std[:, 0], precision**-0.5, rtol=1e-9)
    np.testing.assert_allclose(
        history.mean[:, 0], np.cumsum(y) / RULER_STD**2 / precision, rtol=1e-9
    )


def discrete(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
    """A step that is taken whatever Δt is."""
    return ca.vertcat(x[0] + dt * x[1], x[1] + 0.1 * w[0])


def test_a_model_without_sensors_predicts() -> None:
    estimator = create_estimator("ekf", own_model("cart", STATES, cart, 2, {}))
    state, _ = estimator.step(estimator.init(), Measurement(0.0, np.zeros(0)))
    _, estimate = estimator.step(state, Measurement(2.0, np.zeros(0)))
    assert estimate.status is Status.NO_READING
    (distance, _), (speed, _) = STATES.values()
    assert estimate.state.mean == pytest.approx([distance + 2.0 * speed, speed])


def test_a_state_where_a_model_is_not_defined_says_nothing_of_an_empty_step() -> None:
    """A rod of length 1 ± 1 m: at one deviation below its mean it has none."""
    states = {"angle_rad": (0.1, 0.1), "length_m": (1.0, 1.0)}

    def swings(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
        return ca.vertcat(x[0] - dt * x[0] / x[1], x[1])

    model = cart_model(states, swings)
    assert not np.isfinite(model.f([0.1, 0.0], 0.0, 0.01).full()).all()


def hidden(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
    """A step that needs no time, where the cart stands far behind only."""
    back = ca.if_else(x[0] < STATES["distance_m"][0] - 1.2 * STATES["distance_m"][1], 0.1, 0.0)
    return cart(x, w, dt) + ca.vertcat(back, 0)


BAD: Mapping[str, tuple[Callable[[], object], str]] = {
    "a mean alone": (
        lambda: cart_model({"distance_m": 0.3, "speed_m_s": (0, 1)}),
        r"state distance_m starts from 0.3, expected \(mean, positive standard deviation\)",
    ),
    "known exactly": (
        lambda: cart_model({**STATES, "speed_m_s": (0, 0)}),
        r"state speed_m_s starts from \(0, 0\), expected \(mean, positive standard deviation\)",
    ),
    "too few next states": (
        lambda: cart_model(transition=lambda x, w, dt: x[0] + dt * w[0]),
        r"model cart: transition has shape \(1, 1\), expected \(2, 1\): one row per state",
    ),
    "next states in a row": (
        lambda: cart_model(transition=lambda x, w, dt: cart(x, w, dt).T),
        r"model cart: transition has shape \(1, 2\), expected \(2, 1\)",
    ),
    "noise that needs no time": (
        lambda: cart_model(transition=discrete),
        "a step of Δt = 0 changes speed_m_s, expected that it changes nothing: scale noise by",
    ),
    "a step that needs no time in places": (
        lambda: cart_model(transition=hidden),
        "a step of Δt = 0 changes distance_m, expected that it changes nothing",
    ),
    "a step that divides by Δt": (
        lambda: cart_model(transition=lambda x, w, dt: cart(x, w, dt) * ca.sin(dt) / dt),
        "a step of Δt = 0 changes distance_m",
    ),
    "too many components": (
        lambda: cart_model(ruler=ruler(reads=lambda x: x)),
        r"sensor ruler: its reading has shape \(2, 1\), expected \(1, 1\): one row per axis \(x\)",
    ),
    "components in a row": (
        lambda: cart_model(ruler=ruler(reads=lambda x: x.T, axes={"x": "m", "v": "m/s"})),
        r"reading has shape \(1, 2\), expected \(2, 1\): one row per axis \(x, v\)",
    ),
    "no noise": (
        lambda: cart_model(ruler=ruler(noise_std=0.0)),
        r"model cart: noise_std of ruler is \[0.\], expected positive numbers",
    ),
    "negative noise": (
        lambda: cart_model(ruler=ruler(noise_std=-0.1)),
        r"noise_std of ruler is \[-0.1\], expected positive numbers",
    ),
    "noise of NaN": (lambda: cart_model(ruler=ruler(noise_std=np.nan)), "expected positive numb"),
    "no state": (lambda: cart_model({}), "model cart has no states, expected at least one"),
    "more noises than there are": (
        lambda: cart_model(transition=lambda x, w, dt: x + dt * w[5]),
        r"transition is called with symbols of shapes .* CasADi says: Slice .* out of bounds",
    ),
    "a choice by a symbol": (
        lambda: cart_model(transition=lambda x, w, dt: x if x[0] > 0 else -x),
        "CasADi says: Cannot compute the truth value .* expected expressions .* ca.if_else",
    ),
    "a symbol from elsewhere": (
        lambda: cart_model(transition=lambda x, w, dt: x + dt * ca.SX.sym("wind", 2)),
        "transition depends on wind_0, wind_1, expected nothing but x, w, dt",
    ),
    "a reading of a symbol from elsewhere": (
        lambda: cart_model(ruler=ruler(reads=lambda x: x[0] + ca.SX.sym("wind"))),
        "sensor ruler: its reading depends on wind, expected nothing but x",
    ),
    "a constraint that is no function": (
        lambda: cart_model().constrained("distance_m < 3"),
        r"inequality is 'distance_m < 3', expected a function of \(x\)",
    ),
    "an endless rate": (
        lambda: cart_model(ruler=ruler(rate_hz=np.inf)),
        "sensor ruler: its rate_hz is inf, expected a positive number or None",
    ),
    "a duration of text": (
        lambda: simulate_model(cart_model(), duration_s="1"),
        "duration is '1' s, expected a positive time",
    ),
    "a seed of text": (
        lambda: simulate_model(cart_model(), seed="one"),
        "seed is 'one', expected a whole number from 0",
    ),
    "no rate to simulate with": (
        lambda: simulate_model(cart_model(ruler=ruler(rate_hz=None)), duration_s=1.0),
        "sensor ruler has no rate_hz, expected one to simulate it",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_a_bad_model_is_refused(case: str) -> None:
    build, sentence = BAD[case]
    with pytest.raises(InputError, match=sentence):
        build()


def leaking(x: ca.SX, w: ca.SX, dt: ca.SX, u: ca.SX) -> ca.SX:
    """It is defined for positive levels and inputs only, and its noise is their root."""
    return x - dt * ca.sqrt(x) + ca.sqrt(dt * x * u) * w


@pytest.mark.parametrize("reach", ["inside", "outside"])
def test_a_step_of_no_time_is_looked_at_where_the_model_is_defined(reach: str) -> None:
    """Inside the bounds, for the prior alone goes below zero; with inputs that are not zero."""
    sensors = {"float": OwnSensor(lambda x: x[0], {"h": "m"}, 0.1)}
    bounds = {"level_m": (0.0, None)} if reach == "inside" else None
    states = {"level_m": (0.3, 0.3)}
    model = own_model("tank", states, leaking, 1, sensors, bounds=bounds, inputs=["flow"])
    assert model.n_u == 1
    with pytest.raises(InputError, match="a step of Δt = 0 changes level_m"):
        own_model(
            "tank", states, lambda x, w, dt, u: leaking(x, w, dt, u) + u, 1, sensors,
            bounds=bounds, inputs=["flow"],
        )  # fmt: skip
