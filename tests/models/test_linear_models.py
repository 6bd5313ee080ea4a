"""Linear systems from matrices: the textbook's Kalman filter, whatever the estimator and engine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from estimation.estimator import run
from estimation.recording import Measurement, Recording
from estimation.status import Status
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.linear_models import linear_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator, settings_read
from recordings.simulate_pen import simulate_model
from tests.references import kalman
from tests.references.van_loan import discretised

A = np.array([[0.0, 1.0, 0.0], [-40.0, -2.0, 1.0], [0.0, 0.0, -3.0]])
B = np.array([[0.0, 0.0], [1.0, 0.5], [0.0, 2.0]])
C, D = np.array([[1.0, 0.0, 0.0], [0.5, 1.0, 0.0]]), np.array([[0.0, 0.3], [0.0, 0.0]])
G, R = np.array([[0.0], [0.0], [2.0]]), np.diag([0.05**2, 0.2**2])
MEAN, P = np.array([0.5, -1.0, 0.2]), np.array([[0.3, 0.1, 0], [0.1, 0.9, 0], [0, 0, 0.4]])
T = 0.05
GAPS = np.array([1, 2, 1, 1, 7, 1, 3, 1, 1, 1, 40, 1])


@pytest.fixture(params=["compiled", "interpreted"])
def engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


@pytest.fixture(params=["compiled", pytest.param("interpreted", marks=pytest.mark.slow)])
def slow_engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


def continuous(**changes: Any) -> StateSpaceModel:
    settings: dict[str, Any] = {"G": G, "R": R, "B": B, "D": D, "prior": GaussianState(MEAN, P)}
    return linear_model("filtered spring", A, C, **{**settings, **changes})


def discrete(**changes: Any) -> StateSpaceModel:
    F, held, Q = discretised(A, B, G @ G.T, T)
    settings: dict[str, Any] = {"Q": Q, "B": held, "D": D, "R": R, "dt_s": T}
    known = GaussianState(MEAN, P)
    return linear_model("sampled spring", F, C, prior=known, **{**settings, **changes})


def recording(times: Array) -> Recording:
    """Readings and inputs of no system at all; some of them are missing."""
    rng = np.random.default_rng(5)
    y = rng.normal(0, 1, (len(times), 2))
    y[rng.uniform(size=y.shape) < 0.3] = np.nan
    inputs = {"u1": np.cos(7 * times), "u2": np.sign(np.sin(9 * times))}
    return Recording("drawn", times, {"y": y}, inputs=inputs)


def filtered(given: Recording, interpolated: list[bool]) -> list[kalman.Posterior]:
    u, x, covariance = np.column_stack(list(given.inputs.values())), MEAN, P
    found: list[kalman.Posterior] = []
    for k, y in enumerate(given.readings["y"]):
        if k:
            F, held, Q = discretised(A, B, G @ G.T, given.time_s[k] - given.time_s[k - 1])
            acting = np.where(interpolated, (u[k - 1] + u[k]) / 2, u[k - 1])
            x, covariance = kalman.predict(found[-1].mean, found[-1].covariance, F, Q)
            x = x + held @ acting
        found.append(kalman.update(x, covariance, y - D @ u[k], C, R))
    return found


def check(name: str, model: StateSpaceModel, given: Recording, interpolated: list[bool]) -> None:
    estimator = create_estimator(name, model, **settings_read(name, {"horizon": 5}))
    history = run(estimator, given)
    for k, wanted in enumerate(filtered(given, interpolated)):
        std = np.sqrt(np.diag(wanted.covariance))
        assert np.abs((history.mean[k] - wanted.mean) / std).max() < 1e-9
        assert np.abs(history.std[k] / std - 1).max() < 1e-9
    assert all(status.is_solved for status in history.status)


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_a_continuous_system_takes_any_step(name: str) -> None:
    """Of a microsecond to 2 s: 80 times what the series takes at once."""
    times = np.cumsum([0.0, 1e-6, *(T * GAPS)])
    check(name, continuous(interpolated=["u1"]), recording(times), [True, False])


@pytest.mark.usefixtures("slow_engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_a_discrete_system_takes_whole_steps(name: str) -> None:
    """Those of several intervals are as many; stamps may be off by some of an interval."""
    times = T * np.cumsum([0, *GAPS])
    stamped = recording(times)
    jitter = 0.02 * T * np.sin(np.arange(len(times)))
    given = Recording("jittery", times + jitter, stamped.readings, inputs=stamped.inputs)
    estimator = create_estimator(name, discrete(), **settings_read(name, {"horizon": 5}))
    history = run(estimator, given)
    check(name, discrete(), stamped, [False, False])
    exact = run(estimator, stamped)
    np.testing.assert_array_equal(history.mean, exact.mean)


@pytest.mark.parametrize("unit", [[1e-6, 1e5, 1e3], [1e6, 1e-4, 1.0], [1.0, 1.0, 1e-9]])
def test_units_do_not_matter(unit: list[float]) -> None:
    """Of a system in microns and bars: what is estimated is the same, to the digits that it has."""
    u, given = np.array(unit), recording(np.cumsum(T * GAPS))
    apart = {"B": B * u[:, None], "G": G * u[:, None]}
    prior = GaussianState(MEAN * u, P * np.outer(u, u))
    other = linear_model("apart", A * np.outer(u, 1 / u), C / u, R=R, D=D, prior=prior, **apart)
    found, wanted = (run(create_estimator("ekf", each), given) for each in (other, continuous()))
    assert set(found.status) == {Status.SOLVED}
    np.testing.assert_allclose(found.std / u, wanted.std, rtol=1e-9)
    off = (found.mean / u - wanted.mean) / wanted.std
    assert np.abs(off).max() < 1e-9


def test_a_chain_of_integrators_is_exact_at_any_length() -> None:
    """Its series ends; noise reaches every state, a constant beside it none."""
    chain = np.diag([1.0, 1.0, 0.0], 1)
    model = linear_model(
        "chain", chain, [1, 0, 0, 1], G=[0, 0, 3, 0], R=1.0, prior=(0.0, [1, 1, 1, 2])
    )
    assert model.n_w == 3
    x = np.array([1.0, -2.0, 0.5, 7.0])
    for dt in (0.0, 1e-3, 100.0):
        F, _, Q = discretised(chain, np.zeros((4, 0)), np.diag([0, 0, 9.0, 0]), dt)
        np.testing.assert_allclose(model.f(x, np.zeros(3), dt).full().ravel(), F @ x, rtol=1e-13)
        L = np.column_stack([model.f(0 * x, e, dt).full().ravel() for e in np.eye(3)])
        np.testing.assert_allclose(L @ L.T, Q, rtol=1e-9, atol=1e-300)


def test_a_long_gap_of_a_stiff_system_has_settled() -> None:
    """A rate of 1000 / s, over 100 s: its stationary variance."""
    model = linear_model("stiff", -1000.0, 1.0, Q=50.0, R=1.0, prior=(0.0, 1.0))
    assert float(model.f(1.0, 0.0, 100.0)) == 0
    np.testing.assert_allclose(float(model.f(0.0, 1.0, 100.0)) ** 2, 50.0 / 2000, rtol=1e-12)


def test_names_units_and_matrices_as_people_give_them() -> None:
    model = linear_model(
        "cart", pd.DataFrame([[0, 1], [0, 0]]), [1, 0], G=[0, 0.5], R=0.01, B=[0, 1],
        prior={"place_m": (1, 0.5), "speed_m_s": (0, 2)}, states=["place_m", "speed_m_s"],
        readings={"ruler": "m"}, inputs=["push_m_s2"], bounds={"speed_m_s": (0, None)}, rate_hz=20,
    )  # fmt: skip
    assert model.state_names == ("place_m", "speed_m_s")
    assert model.state_units == ("m", "m/s")
    assert model.reading_names == ("y_ruler",)
    assert (model.input_names, model.input_units) == (("push_m_s2",), ("m/s²",))
    assert model.lower.tolist() == [-np.inf, 0.0]
    np.testing.assert_array_equal(model.prior.std, [0.5, 2])
    assert model.noise_std.tolist() == [0.1]
    found = simulate_model(model, duration_s=0.2, inputs={"push_m_s2": 1.0})
    assert found.readings["y"].shape == (5, 1)
    full = continuous(R=[[1, 0.5], [0.5, 2]])
    assert not full.sensors[0].row_needs[0, 1]
    assert full.sensors[0].row_needs[1, 0]
    assert simulate_model(discrete(), duration_s=1, inputs={"u1": 0, "u2": 0}).time_s[1] == T


def test_another_interval_is_refused() -> None:
    model = discrete()
    with pytest.raises(
        InputError,
        match=r"0.02 s between rows 1 and 2, but model sampled spring holds for steps of 0.05 s, "
        "expected a whole number of them",
    ):
        run(create_estimator("ekf", model), recording(np.array([0, 0.05, 0.07])))
    with pytest.raises(InputError, match=r"0.001 s between rows 0 and 1"):
        recording(np.array([0, 0.001])).stacked(model)


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_another_interval_of_a_live_stream_is_refused(name: str) -> None:
    """And changes nothing: the next step is made as if it had not been."""
    model = discrete()
    estimator = create_estimator(
        name, model, **settings_read(name, {"horizon": 2, "late_samples": 0})
    )
    y = model.stack({"y": np.ones(2)}, {"u1": 0.0, "u2": 0.0})
    state, _ = estimator.step(estimator.init(), Measurement(0.0, y))
    state, _ = estimator.step(state, Measurement(T, y))
    with pytest.raises(
        InputError, match=r"0.02 s since the last measurement, but model sampled spring holds for"
    ):
        estimator.step(state, Measurement(T + 0.02, y))
    for time_s in (T, 3 * T):
        _, estimate = estimator.step(state, Measurement(time_s, y))
        assert estimate.status & ~Status.IMPROBABLE is Status.SOLVED
    _, late = estimator.step(state, Measurement(0.0, y))
    assert late.time_s == T


@pytest.mark.parametrize("name", ["mhe-rti", "mhe", "mhe-ipopt"])
def test_a_late_reading_between_two_intervals_is_refused(name: str) -> None:
    model = discrete()
    estimator = create_estimator(name, model, **settings_read(name, {"horizon": 3}))
    y = model.stack({"y": np.ones(2)}, {"u1": 0.0, "u2": 0.0})
    state = estimator.init()
    for k in (0, 1, 3):
        state, _ = estimator.step(state, Measurement(k * T, y))
    with pytest.raises(InputError, match=r"0\.08 s since the last measurement, but model sampled"):
        estimator.step(state, Measurement(3 * T - 0.08, y))
    _, estimate = estimator.step(state, Measurement(2 * T, y))
    assert estimate.window.time_s.tolist() == [0.0, T, 2 * T, 3 * T]


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "A": ({"A": np.zeros((2, 3))}, r"model bad: A has shape \(2, 3\), expected \(2, 2\) finite"),
    "A of texts": ({"A": [["a"]]}, r"model bad: A: list that holds no numbers, expected \(n, n\)"),
    "A of NaN": ({"A": [[0, np.nan], [0, 0]]}, "A has entries that are not finite"),
    "C": ({"C": [1, 0, 0]}, r"C has shape \(3,\), expected \(n, 2\) finite numbers"),
    "B": ({"B": [1, 0, 0]}, r"B has shape \(3,\), expected \(2, n\) finite numbers"),
    "D": ({"B": [0, 1], "D": [[1, 2]]}, r"D has shape \(1, 2\), expected \(1, 1\)"),
    "no noise": ({"Q": None}, r"neither Q nor G, expected one \(Q=0 has no noise\)"),
    "Q": ({"Q": np.eye(3)}, r"Q has shape \(3, 3\), expected \(2, 2\)"),
    "Q of a large state and a small one": (
        {"Q": [[1e10, 2e2], [2e2, 1e-6]]},
        "Q is not positive semidefinite, expected a covariance",
    ),
    "Q asymmetric": ({"Q": [[1, 1], [0, 1]]}, "Q is not symmetric, expected a covariance"),
    "Q negative": ({"Q": -1.0}, "Q is not positive semidefinite"),
    "Q with G": ({"G": [0, 1], "Q": np.eye(2)}, r"Q has shape \(2, 2\), expected \(1, 1\)"),
    "R": ({"R": [[1, 0], [0, 1]]}, r"R has shape \(2, 2\), expected \(1, 1\)"),
    "R of zero": ({"R": 0.0}, "R is not positive definite, expected a covariance"),
    "dt": ({"dt_s": 0.0}, "dt_s is 0.0, expected a positive time, or None"),
    "states": ({"states": ["a"]}, r"states are \('a',\), expected 2 different names"),
    "inputs": ({"inputs": ["a"]}, r"inputs are \('a',\), expected 0 different names"),
    "prior's mean": ({"prior": ([0, 0, 0], 1)}, r"prior's mean have shape \(3,\), expected \(2,\)"),
    "prior's deviation": ({"prior": (0, [1, 0])}, "deviations are .*, expected positive numbers"),
    "prior of three": ({"prior": (0, 1, 2)}, "the prior has 3 parts, expected mean and"),
    "prior's covariance": ({"prior": (0, [[1, 2], [2, 1]])}, "covariance is not positive definite"),
    "prior's states": ({"prior": {"x1": (0, 1)}}, "the prior has no x2, expected every state"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_matrices_are_refused(case: str) -> None:
    changes, sentence = BAD[case]
    good = {"A": np.zeros((2, 2)), "C": [1, 0], "Q": 1.0, "R": 1.0, "prior": (0, 1)}
    with pytest.raises(InputError, match=sentence):
        linear_model("bad", **{**good, **changes})
