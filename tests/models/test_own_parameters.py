"""Constant parameters to estimate: states of an augmented Kalman filter, whatever the estimator."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import least_squares

from estimation.estimator import run
from estimation.recording import Recording
from estimation.status import Status
from models.arrays import Array
from models.differential import ode
from models.errors import InputError
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator, settings_read
from recordings.simulate_pen import simulate_model
from tests.references import kalman

ENGINES = ("compiled", "interpreted")
TIMES = np.concatenate([[0.0, 0.02, 0.1], 0.1 + 0.1 * np.cumsum(1 + 0.3 * np.sin(np.arange(12)))])
H = np.array([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]])
R = np.diag([0.1**2, 0.2**2])
WALK, DENSITY = 0.05, 0.4


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


def sledge(**changes: Any) -> StateSpaceModel:
    """A slope pulls by a constant that nobody knows; a ruler's zero wanders."""

    def transition(x: ca.SX, w: ca.SX, dt: ca.SX, p: ca.SX) -> ca.SX:
        place = x[0] + dt * x[1] + dt**2 / 2 * p[0]
        return ca.vertcat(place, x[1] + dt * p[0] + DENSITY * ca.sqrt(dt) * w[0])

    sensors = {
        "ruler": OwnSensor(lambda x, p: x[0] + p[1], {"x": "m"}, 0.1, 10.0),
        "speed": OwnSensor(lambda x: x[1], {"v": "m/s"}, 0.2, 10.0),
    }
    settings: dict[str, Any] = {
        "parameters": {"pull_m_s2": (0.0, 2.0), "zero_m": (0.1, 0.3)},
        "walks": {"zero_m": WALK},
    }
    states = {"place_m": (0.0, 0.5), "speed_m_s": (1.0, 0.5)}
    return own_model("sledge", states, transition, 1, sensors, **{**settings, **changes})


def F(dt: float) -> Array:
    return np.array([[1, dt, dt**2 / 2, 0], [0, 1, dt, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def Q(dt: float) -> Array:
    return dt * np.diag([0, DENSITY**2, 0, WALK**2])


def recording() -> Recording:
    t = TIMES
    ruler = 0.2 + t - 0.4 * t**2 + 0.1 * np.sin(40 * t)
    speed = np.where(np.arange(len(t)) % 3, 1 - 0.8 * t + 0.2 * np.cos(50 * t), np.nan)
    return Recording("sledge", t, {"ruler": ruler[:, None], "speed": speed[:, None]})


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_every_estimator_is_the_augmented_kalman_filter(name: str) -> None:
    model, given = sledge(), recording()
    estimator = create_estimator(name, model, **settings_read(name, {"horizon": 6}))
    history = run(estimator, given)
    y = list(np.hstack([given.readings["ruler"], given.readings["speed"]]))
    prior = np.array([0.0, 1.0, 0.0, 0.1]), np.diag([0.5, 0.5, 2.0, 0.3]) ** 2
    for k, wanted in enumerate(kalman.run(prior, TIMES, y, F, Q, H, R)):
        std = np.sqrt(np.diag(wanted.covariance))
        assert np.abs((history.mean[k] - wanted.mean) / std).max() < 1e-9
        assert np.abs(history.std[k] / std - 1).max() < 1e-9
    assert set(history.status) == {Status.SOLVED}
    np.testing.assert_array_equal(history.column("pull_m_s2"), history.mean[:, 2])
    np.testing.assert_array_equal(history.std_of("zero_m"), history.std[:, 3])


def test_a_parameter_is_a_state_without_noise() -> None:
    model = sledge()
    assert model.state_names == ("place_m", "speed_m_s", "pull_m_s2", "zero_m")
    assert model.state_units == ("m", "m/s", "m/s²", "m")
    assert model.n_w == 2
    assert sledge(walks=None).n_w == 1
    assert "pull_m_s2" in repr(model)
    bounded = sledge(bounds={"zero_m": (0.0, None)}, units={"pull_m_s2": "N/kg"})
    assert bounded.lower.tolist() == [-np.inf] * 3 + [0.0]
    assert bounded.state_units[2] == "N/kg"


def pendulum(mean: float = 1.0) -> StateSpaceModel:
    """A swing of unknown length under a known torque: f is curved in the parameter."""

    def rate(x: ca.SX, w: ca.SX, u: ca.SX, p: ca.SX) -> ca.SX:
        return ca.vertcat(x[1], u[0] - 9.81 / p[0] * ca.sin(x[0]) + 0.1 * w[0])

    sensors = {"camera": OwnSensor(lambda x, u, p: p[0] * ca.sin(x[0]), {"x": "m"}, 0.01, 20.0)}
    return own_model(
        "swing", {"angle_rad": (0.5, 0.2), "rate_rad_s": (0.0, 0.2)}, ode(rate), 1, sensors,
        inputs={"torque": "1/s²"}, parameters={"length_m": (mean, 0.3)},
        bounds={"length_m": (0.1, 5.0)},
    )  # fmt: skip


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", ["mhe", "mhe-ipopt"])
def test_a_curved_parameter_is_scipys_optimum(name: str) -> None:
    """All readings in one window, rolled out by itself: Runge-Kutta of order 4."""
    model, n = pendulum(), 9
    given = simulate_model(model, duration_s=0.4, seed=3, inputs={"torque": 0.7})
    history = run(create_estimator(name, model, horizon=n), given)
    std, dt = np.array([0.2, 0.2, 0.3]), 0.05

    def moved(x: Array, w: float) -> Array:
        def slope(s: Array) -> Array:
            force = 0.7 - 9.81 / s[2] * np.sin(s[0]) + 0.1 * w / np.sqrt(dt)
            return np.array([s[1], force, 0.0])

        k1 = slope(x)
        k2 = slope(x + dt / 2 * k1)
        k3 = slope(x + dt / 2 * k2)
        return x + dt / 6 * (k1 + 2 * k2 + 2 * k3 + slope(x + dt * k3))

    def states(z: Array) -> Array:
        x = [np.array([0.5, 0.0, 1.0]) + std * z[:3]]
        for w in z[3:]:
            x.append(moved(x[-1], w))
        return np.array(x)

    def residual(z: Array) -> Array:
        x = states(z)
        return np.concatenate(
            [z, (given.readings["camera"][:, 0] - x[:, 2] * np.sin(x[:, 0])) / 0.01]
        )

    assert len(given.time_s) == n
    best = least_squares(residual, np.zeros(n + 2), xtol=1e-15, ftol=1e-15, gtol=1e-14)
    assert np.abs((history.mean[-1] - states(best.x)[-1]) / history.std[-1]).max() < 1e-6
    assert history.column("length_m")[-1] != pytest.approx(1.0, abs=0.01)


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "a state's name": (
        {"parameters": {"place_m": (0, 1)}, "walks": None},
        "model sledge: parameter place_m is the name of a state, expected a name of its own",
    ),
    "no deviation": (
        {"parameters": {"pull_m_s2": 1.0}},
        r"parameter pull_m_s2 starts from 1.0, expected \(mean, positive standard deviation\)",
    ),
    "not finite": (
        {"parameters": {"pull_m_s2": (np.nan, 1.0)}},
        r"parameter pull_m_s2 starts from \(nan, 1.0\), expected",
    ),
    "no mapping": ({"parameters": ["pull"]}, r"parameters are \['pull'\], expected name →"),
    "walk of nothing": ({"walks": {"zero": 0.1}}, "walk of parameter zero is unknown, .*zero_m"),
    "walk of zero": ({"walks": {"zero_m": 0.0}}, "parameter zero_m walks by 0.0, expected a pos"),
    "no parameters": (
        {"parameters": None, "walks": None},
        r"transition takes \(x.*p.*\).*, expected a function of \(x, w, dt\)",
    ),
    "inputs too": (
        {"inputs": ["force"]},
        r"transition takes .*, expected a function of \(x, w, dt, u, p\)",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_parameters_are_refused(case: str) -> None:
    changes, sentence = BAD[case]
    with pytest.raises(InputError, match=sentence):
        sledge(**changes)


def test_a_step_of_no_time_moves_no_parameter() -> None:
    """A walk needs time."""
    model = sledge()
    np.testing.assert_array_equal(model.f(np.arange(4.0), np.ones(2), 0.0).full().ravel(), range(4))
