"""Differential equations as transitions, against the matrix exponential and SciPy."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from estimation.estimator import run
from estimation.status import Status
from models.differential import ode
from models.errors import InputError
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator
from recordings.simulate_pen import simulate_model

A = np.array([[0.0, 1.0], [-1.0, -0.5]])
DENSITY = 0.3


def spring(x: ca.SX, w: ca.SX) -> ca.SX:
    return ca.vertcat(x[1], -x[0] - 0.5 * x[1] + DENSITY * w[0])


def spring_model(**settings: Any) -> StateSpaceModel:
    states = {"place_m": (1.0, 0.1), "speed_m_s": (0.0, 0.1)}
    sensors = {"ruler": OwnSensor(lambda x: x[0], {"x": "m"}, 0.05, 10.0)}
    return own_model("spring", states, ode(spring, **settings), 1, sensors)


@pytest.mark.parametrize(("method", "order"), [("euler", 1), ("rk4", 4), ("collocation", 5)])
def test_the_order_is_the_methods(method: str, order: int) -> None:
    """Halving the steps divides the error of one second by 2^order."""
    start = np.array([1.0, 0.2])
    f = [spring_model(method=method, substeps=n).f for n in (2, 4)]
    errors = [np.abs(g(start, 0, 1.0).full().ravel() - expm(A) @ start).max() for g in f]
    assert abs(np.log2(errors[0] / errors[1]) - order) < 0.4


@pytest.mark.parametrize(("method", "substeps"), [("collocation", 40), ("cvodes", 1)])
def test_a_stiff_equation_is_scipys(method: str, substeps: int) -> None:
    """Van der Pol with μ = 100: rates of 300 / s, steps of an eightieth of a second."""
    transition = ode(
        lambda x, w: ca.vertcat(x[1], 100 * (1 - x[0] ** 2) * x[1] - x[0]),
        method=method,
        substeps=substeps,
    )
    x, dt = ca.SX.sym("x", 2), ca.SX.sym("dt")
    f = ca.Function("f", [x, dt], [transition(x, ca.SX(0, 1), dt)])
    wanted = solve_ivp(
        lambda t, x: [x[1], 100 * (1 - x[0] ** 2) * x[1] - x[0]],
        (0, 0.5), [2.0, 0.0], method="Radau", rtol=1e-10, atol=1e-12,
    ).y[:, -1]  # fmt: skip
    np.testing.assert_allclose(f([2.0, 0.0], 0.5).full().ravel(), wanted, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(f([2.0, 0.1], 0.0).full().ravel(), [2.0, 0.1], rtol=1e-15)


def test_steps_are_halved_until_none_is_too_long() -> None:
    halved = spring_model(longest_step_s=0.03).f
    for dt, substeps in ((0.03, 1), (0.04, 2), (0.1, 4), (0.25, 16)):
        wanted = spring_model(substeps=substeps).f([1.0, 0.2], 0.5, dt).full()
        np.testing.assert_allclose(halved([1.0, 0.2], 0.5, dt).full(), wanted, rtol=1e-14)


def test_the_noise_is_white_whatever_the_steps_are() -> None:
    """A rate of its own density: variance q² Δt after Δt, in one step or many."""
    x, w, dt = ca.SX.sym("x"), ca.SX.sym("w"), ca.SX.sym("dt")
    f = ca.Function("f", [x, w, dt], [ode(lambda x, w: DENSITY * w)(x, w, dt)])
    for step in (0.01, 0.5):
        np.testing.assert_allclose(float(f(0, 1, step)) ** 2, DENSITY**2 * step, rtol=1e-12)


@pytest.mark.cover
@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
@pytest.mark.parametrize("settings", [{"method": "collocation"}, {"longest_step_s": 0.03}])
def test_every_estimator_takes_it(
    settings: Any, engine: str, request: pytest.FixtureRequest
) -> None:
    """The model is linear: all are the Kalman filter of the written-out equation."""
    if engine == "interpreted":
        request.getfixturevalue("interpreted")
    exact = spring_model(substeps=4)
    recording = simulate_model(exact, duration_s=1.0, seed=1)
    wanted = run(create_estimator("ekf", exact), recording)
    for name in LEAST_SQUARES:
        history = run(create_estimator(name, spring_model(**settings)), recording)
        assert set(history.status) == {Status.SOLVED}
        np.testing.assert_allclose(history.mean, wanted.mean, rtol=0, atol=1e-6)
        np.testing.assert_allclose(history.std, wanted.std, rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"method": "rk5"}, "method rk5 is unknown, expected one of rk4, euler, collocation"),
        ({"substeps": 0}, "substeps is 0, expected a whole number of at least 1"),
        ({"longest_step_s": 0.0}, "longest_step_s is 0.0, expected a positive time"),
        ({"substeps": 2, "longest_step_s": 0.1}, "expected one of them"),
        ({"method": "cvodes", "substeps": 2}, "cvodes chooses its own steps"),
    ],
)
def test_bad_settings_are_refused(settings: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        ode(spring, **settings)


def test_a_rate_of_another_shape_is_refused() -> None:
    with pytest.raises(InputError, match=r"rate has shape \(1, 1\), expected \(2, 1\)"):
        own_model("short", {"a_m": (0, 1), "b_m": (0, 1)}, ode(lambda x, w: x[0]), 1, {})


@pytest.mark.parametrize(
    ("rate", "sentence"),
    [
        (lambda x: x, r"rate takes \(x\), expected a function of \(x, w\)"),
        (lambda x, w, p: x, r"rate takes \(x, w, p\), expected a function of \(x, w\)"),
        (None, r"rate is None, expected a function of \(x, w\)"),
        (lambda x, w: "x", r"rate is str, expected \(2, 1\) expressions"),
    ],
)
def test_a_rate_that_is_no_function_of_the_model_is_refused(rate: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        own_model("bad", {"a_m": (0, 1), "b_m": (0, 1)}, ode(rate), 1, {})


def test_a_rate_may_be_a_list() -> None:
    listed = ode(lambda x, w: [x[1], -x[0] - 0.5 * x[1] + DENSITY * w[0]])
    model = own_model("spring", {"place_m": (1.0, 0.1), "speed_m_s": (0.0, 0.1)}, listed, 1, {})
    for given in ((0.3, -1.0), (2.0, 0.1)):
        found, wanted = (f(given, 0.7, 0.1).full() for f in (model.f, spring_model().f))
        np.testing.assert_array_equal(found, wanted)
