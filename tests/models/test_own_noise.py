"""Noise known with each reading, against a Kalman filter whose R varies in time."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.exported import Exported
from estimation.estimator import run, run_measurements
from estimation.information_bound import information_bound
from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator, settings_read
from recordings.simulate_pen import simulate_model
from tests.engines import needs_compiler
from tests.references import kalman

STEP_S, WALK, N = 0.1, 0.4, 12
EYE = np.eye(2)


def boat(**noise: Any) -> StateSpaceModel:
    """A satellite receiver that says how far off it may be, east and north."""
    sensors = {"gps": OwnSensor(lambda x: x, {"east": "m", "north": "m"}, rate_hz=10.0, **noise)}
    return own_model(
        "boat",
        {"east_m": (0.0, 2.0), "north_m": (1.0, 2.0)},
        lambda x, w, dt, u: x + WALK * ca.sqrt(dt) * w,
        2,
        sensors,
        inputs={"east_std": "m", "north_std": "m", "together": ""},
    )


def covariance(u: Any) -> Any:
    both = u[2] * u[0] * u[1]
    return ca.vertcat(ca.horzcat(u[0] ** 2, both), ca.horzcat(both, u[1] ** 2))


CASES: dict[str, tuple[dict[str, Any], Any]] = {
    "names": ({"noise_std": ["east_std", "north_std"]}, lambda e, n, c: np.diag([e**2, n**2])),
    "one name": ({"noise_std": "east_std"}, lambda e, n, c: e**2 * EYE),
    "beside a number": ({"noise_std": (0.2, "north_std")}, lambda e, n, c: np.diag([0.04, n**2])),
    "function": ({"noise_std": lambda u: 3 * u[:2]}, lambda e, n, c: np.diag([9 * e**2, 9 * n**2])),
    "full": (
        {"noise_covariance": covariance},
        lambda e, n, c: np.array([[e**2, c * e * n], [c * e * n, n**2]]),
    ),
}


def known_with_each_reading() -> tuple[Recording, Array]:
    """Return a recording whose second half is 50 times worse, and its inputs (n, 3)."""
    rng = np.random.default_rng(3)
    u = np.column_stack([rng.uniform(0.05, 0.2, (N, 2)), rng.uniform(-0.8, 0.8, N)])
    u[N // 2 :, :2] *= 50
    y = rng.normal(size=(N, 2)).cumsum(axis=0)
    y[4, 0] = np.nan
    y[7] = np.nan
    inputs = dict(zip(("east_std", "north_std", "together"), u.T, strict=True))
    return Recording("boat", STEP_S * np.arange(N), {"gps": y}, inputs=inputs), u


@pytest.fixture(params=("compiled", "interpreted"))
def engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
@pytest.mark.parametrize("case", ["names", "full"])
def test_every_estimator_is_the_filter_with_that_noise(name: str, case: str) -> None:
    """Over windows that slide; NIS, too, whose rows are in standard deviations."""
    assert_is_the_filter(name, case)


@pytest.mark.parametrize("case", sorted(set(CASES) - {"names", "full"}))
def test_any_way_to_tell_it(case: str) -> None:
    assert_is_the_filter("ekf", case)


def assert_is_the_filter(name: str, case: str) -> None:
    noise, R_of = CASES[case]
    model, (recording, u) = boat(**noise), known_with_each_reading()
    y = recording.readings["gps"]
    if case == "full":  # half a reading says nothing by the row behind what it lacks
        y[np.isnan(y[:, 0])] = np.nan
    history = run(create_estimator(name, model, **settings_read(name, {"horizon": 5})), recording)
    found = kalman.run_varying(
        (model.prior.mean, model.prior.covariance),
        list(recording.time_s),
        list(y),
        lambda dt: EYE,
        lambda dt: WALK**2 * dt * EYE,
        EYE,
        [R_of(*row) for row in u],
    )
    std = np.array([np.sqrt(np.diag(p.covariance)) for p in found])
    assert np.abs((history.mean - [p.mean for p in found]) / std).max() < 1e-9
    assert np.abs(history.std / std - 1).max() < 1e-9
    wanted = [p.innovation @ np.linalg.solve(p.innovation_covariance, p.innovation) for p in found]
    column = list(history.row_sets).index("measured")
    nis = np.nan_to_num(history.squared_innovations[:, column])
    np.testing.assert_allclose(nis, wanted, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("case", ["names", "full"])
def test_a_simulated_reading_is_that_far_off(case: str) -> None:
    noise, R_of = CASES[case]
    signals = {"east_std": lambda t: 0.1 + t, "north_std": 0.3, "together": 0.6}
    found = simulate_model(boat(**noise), duration_s=300.0, seed=2, inputs=signals)
    assert found.truth is not None
    off = found.readings["gps"] - found.truth.states(("east_m", "north_m"), found.time_s)
    u = np.column_stack([found.inputs[name] for name in signals])
    whitened = [
        np.linalg.solve(np.linalg.cholesky(R_of(*row)), r) for row, r in zip(u, off, strict=True)
    ]
    assert np.abs(np.cov(np.transpose(whitened)) - EYE).max() < 0.07


def test_the_information_bound_is_the_filters() -> None:
    """Of a linear system, wherever it is."""
    noise, R_of = CASES["names"]
    model, (recording, u) = boat(**noise), known_with_each_reading()
    given = list(recording.measurements(model))
    P, wanted = model.prior.covariance, []
    for k, y in enumerate(recording.readings["gps"]):
        P = P + WALK**2 * STEP_S * EYE if k else P
        P = kalman.update(np.zeros(2), P, y, EYE, R_of(*u[k])).covariance
        wanted.append(np.sqrt(np.diag(P)))
    found = information_bound(model, given, np.zeros((N, 2)))
    np.testing.assert_allclose(found.std, wanted, rtol=1e-9)


@needs_compiler
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_the_export_says_what_the_estimator_says(name: str) -> None:
    model, (recording, _) = boat(**CASES["names"][0]), known_with_each_reading()
    settings = settings_read(name, {"horizon": 5})
    exported = Exported(export_texts(exportable(name, model, **settings), "double"))
    theirs = run_measurements(exported, recording.measurements(model))
    ours = run(create_estimator(name, model, **settings), recording)
    assert (np.abs(theirs.mean - ours.mean) / ours.std).max() < 1e-9


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_a_deviation_of_zero_says_nothing(name: str) -> None:
    """As if the reading were missing; and a missing one may have it."""
    model, (recording, u) = boat(noise_std=["east_std", "north_std"]), known_with_each_reading()
    settings = settings_read(name, {"horizon": 5})
    u[[3, 7], :2] = 0.0
    inputs = dict(zip(recording.inputs, u.T, strict=True))
    y = recording.readings["gps"].copy()
    given = Recording("boat", recording.time_s, {"gps": y.copy()}, inputs=inputs)
    y[3] = np.nan
    without = Recording("boat", recording.time_s, {"gps": y}, inputs=inputs)
    one, other = (run(create_estimator(name, model, **settings), r) for r in (given, without))
    assert (np.abs(one.mean - other.mean) / other.std).max() < 1e-9
    assert all(status.is_solved for status in one.status)


def test_it_is_told_in_deviations() -> None:
    model = boat(noise_std="east_std")
    assert model.sensors[0].unit_of_row == ("σ", "σ")
    assert "gps (own, 10 Hz): noise 1 σ (2 rows)" in repr(model)


@pytest.mark.parametrize(
    ("noise", "sentence"),
    [
        ({"noise_std": "est_std"}, "noise_std is the input est_std is unknown, expected one of"),
        ({"noise_std": ["east_std"] * 3}, r"noise_std has shape \(3, 1\), expected \(2,\)"),
        ({"noise_std": lambda u: u}, r"noise_std has shape \(3, 1\), expected \(2,\)"),
        ({"noise_covariance": lambda u: u[0]}, r"noise_covariance \(1, 1\), expected symmetric"),
        (
            {"noise_covariance": lambda u: ca.vertcat(u[:2].T, ca.horzcat(0, 1))},
            r"noise_covariance \(2, 2\), expected symmetric",
        ),
        ({}, "expected either noise_std or noise_covariance"),
    ],
)
def test_a_noise_that_does_not_fit_is_refused(noise: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        boat(**noise)


def test_without_inputs_there_is_nothing_to_depend_on() -> None:
    sensor = OwnSensor(lambda x: x[0], {"a": "m"}, lambda u: u[0])
    with pytest.raises(InputError, match="a function of inputs and the model has none"):
        own_model("bare", {"a_m": (0, 1)}, lambda x, w, dt: x + dt**0.5 * w, 1, {"s": sensor})
