"""Every way to step a differential equation, on every estimator and engine, against e^{A Δt}."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from estimation.estimator import run
from estimation.recording import Recording
from estimation.status import Status
from models.arrays import Array
from models.differential import ode
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator, settings_read
from tests.references import kalman
from tests.references.van_loan import discretised

A, B = np.array([[0.0, 1.0, 0.0], [-4.0, -0.5, 1.0], [0, 0, 0]]), np.array([[0.0], [1.0], [0.0]])
DENSITY, STEP_S = 0.3, 0.1
METHODS: dict[str, dict[str, Any]] = {
    "rk4": {"substeps": 20},
    "halved": {"longest_step_s": 0.006},
    "collocation": {"method": "collocation", "substeps": 3},
    "cvodes": {"method": "cvodes"},
}
QUICK = ("rk4", "collocation")


@pytest.fixture(params=["compiled", pytest.param("interpreted", marks=pytest.mark.slow)])
def engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


def spring(settings: dict[str, Any]) -> StateSpaceModel:
    """Pushed by a known force and by a weight, the parameter."""

    def rate(x: ca.SX, w: ca.SX, u: ca.SX, p: ca.SX) -> ca.SX:
        return ca.vertcat(x[1], -4 * x[0] - 0.5 * x[1] + p[0] + u[0] + DENSITY * w[0])

    return own_model(
        "spring", {"place_m": (1.0, 0.3), "speed_m_s": (0.0, 0.3)}, ode(rate, **settings), 1,
        {"ruler": OwnSensor(lambda x: x[0], {"x": "m"}, 0.05)},
        inputs={"force": "N"}, parameters={"weight": (0.2, 0.5)},
    )  # fmt: skip


def recording() -> Recording:
    times = STEP_S * np.arange(16)
    readings = {"ruler": np.cos(2 * times) + 0.05 * np.sin(31 * times)}
    return Recording("swing", times, readings, inputs={"force": np.sin(5 * times)})


def filtered(given: Recording) -> list[kalman.Posterior]:
    """Noise and force are held over a step, as `ode` says."""
    F, held, _ = discretised(A, B, 0 * A, STEP_S)
    Q = DENSITY**2 / STEP_S * held @ held.T
    x, P = np.array([1.0, 0.0, 0.2]), np.diag([0.09, 0.09, 0.25])
    H, R, found = np.array([[1.0, 0.0, 0.0]]), np.array([[0.05**2]]), list[kalman.Posterior]()
    for k, y in enumerate(given.readings["ruler"]):
        if k:
            x, P = kalman.predict(found[-1].mean, found[-1].covariance, F, Q)
            x = x + held[:, 0] * given.inputs["force"][k - 1]
        found.append(kalman.update(x, P, y, H, R))
    return found


@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
@pytest.mark.parametrize(
    "method",
    [*QUICK, *(pytest.param(m, marks=pytest.mark.slow) for m in METHODS if m not in QUICK)],
)
def test_every_estimator_is_the_kalman_filter(method: str, name: str) -> None:
    """With a known force and a parameter, to what the method's own error leaves."""
    given = recording()
    settings = settings_read(name, {"horizon": 4})
    history = run(create_estimator(name, spring(METHODS[method]), **settings), given)
    for k, wanted in enumerate(filtered(given)):
        std = np.sqrt(np.diag(wanted.covariance))
        assert np.abs((history.mean[k] - wanted.mean) / std).max() < 1e-7
        assert np.abs(history.std[k] / std - 1).max() < 1e-7
    assert set(history.status) == {Status.SOLVED}


@pytest.mark.parametrize("method", METHODS)
def test_a_curved_step_is_scipys(method: str) -> None:
    """Of a pendulum whose length is the parameter, under a known torque, in noise that is held."""

    def rate(x: ca.SX, w: ca.SX, u: ca.SX, p: ca.SX) -> ca.SX:
        return ca.vertcat(x[1], u[0] - 9.81 / p[0] * ca.sin(x[0]) + DENSITY * w[0])

    model = own_model(
        "swing", {"angle": (0.5, 0.2), "rate": (0.0, 0.2)}, ode(rate, **METHODS[method]), 1, {},
        inputs=["torque"], parameters={"length": (1.0, 0.1)}, walks={"length": 0.2},
    )  # fmt: skip
    x, w, torque = np.array([1.2, -0.4, 0.8]), np.array([0.7, -0.3]), 2.0

    def slope(t: float, s: Array) -> list[float]:
        noise = DENSITY * w[0] / np.sqrt(STEP_S)
        return [s[1], torque - 9.81 / x[2] * np.sin(s[0]) + noise]

    exact = solve_ivp(slope, (0, STEP_S), x[:2], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    wanted = [*exact, x[2] + 0.2 * np.sqrt(STEP_S) * w[1]]
    found = model.f(x, w, STEP_S, torque, torque).full().ravel()
    np.testing.assert_allclose(found, wanted, rtol=0, atol=3e-9)
