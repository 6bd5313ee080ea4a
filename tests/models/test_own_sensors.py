"""Wrapped angles and full noise covariances of one's own model, against the Kalman filter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.estimator import run
from estimation.recording import Recording
from models.errors import InputError
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator
from tests.references import kalman

ENGINES = ("compiled", "interpreted")
HEADINGS = (3.0, 3.1, -3.13, -3.05, -2.9)
R = np.array([[0.04, 0.03], [0.03, 0.09]])


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


def compass() -> StateSpaceModel:
    sensors = {"compass": OwnSensor(lambda x: x[0], {"north": "rad"}, 0.1, wraps=["north"])}
    return own_model(
        "ship", {"heading": (3.0, 0.5)}, lambda x, w, dt: x + 0.3 * dt**0.5 * w, 1, sensors,
        angles=["heading"], units={"heading": "rad"},
    )  # fmt: skip


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_a_heading_goes_past_south(name: str) -> None:
    """As the Kalman filter of the angle that never wrapped."""
    times = 0.1 * np.arange(len(HEADINGS))
    y = np.array(HEADINGS)[:, None]
    history = run(create_estimator(name, compass()), Recording("ship", times, {"compass": y}))
    unwound = list(np.unwrap(y, axis=0))
    one = np.eye(1)
    found = kalman.run(
        (np.array([3.0]), 0.25 * one), times, unwound,
        lambda dt: one, lambda dt: 0.09 * dt * one, one, 0.01 * one,
    )  # fmt: skip
    wanted = np.array([k.mean[0] for k in found])
    assert wanted.max() > np.pi
    assert (np.abs(history.mean) <= np.pi).all()
    apart = history.mean[:, 0] - wanted
    assert np.abs(apart - 2 * np.pi * np.round(apart / (2 * np.pi))).max() < 1e-8
    assert compass().state_units == ("rad",)


def pair(**noise: Any) -> StateSpaceModel:
    sensors = {"both": OwnSensor(lambda x: x, {"a": "K", "b": ""}, **noise)}
    return own_model(
        "pair", {"temp_K": (300.0, 1.0), "soc": (0.5, 1.0)},
        lambda x, w, dt: x + 0.1 * dt**0.5 * w, 2, sensors, units={"temp_K": "K"},
    )  # fmt: skip


@pytest.mark.cover
@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
@pytest.mark.parametrize("full", [True, False])
def test_noise_per_axis_or_together_is_the_kalman_filters(name: str, full: bool) -> None:
    noise = R if full else np.diag(np.diag(R))
    given = {"noise_covariance": R.tolist()} if full else {"noise_std": [0.2, 0.3]}
    times = 0.1 * np.arange(5)
    y = np.column_stack([300 + np.sin(9 * times), 0.5 + np.cos(7 * times)])
    history = run(create_estimator(name, pair(**given)), Recording("pair", times, {"both": y}))
    eye = np.eye(2)
    prior = pair(**given).prior
    found = kalman.run(
        (prior.mean, prior.covariance), times, list(y),
        lambda dt: eye, lambda dt: 0.01 * dt * eye, eye, noise,
    )  # fmt: skip
    for k, wanted in enumerate(found):
        assert np.abs(history.mean[k] - wanted.mean).max() < 1e-8
        assert np.abs(history.std[k] - np.sqrt(np.diag(wanted.covariance))).max() < 1e-8
    assert pair(**given).state_units == ("K", "")


@pytest.mark.parametrize(
    ("noise", "sentence"),
    [
        ({}, "sensor both: expected either noise_std or noise_covariance"),
        ({"noise_std": [0.1]}, r"noise_std has shape \(1,\), expected \(2,\)"),
        ({"noise_covariance": [[1, 2], [2, 1]]}, "noise_covariance is not positive definite"),
        ({"noise_covariance": [[1, 0], [1, 1]]}, "expected symmetric"),
        ({"noise_std": 0.1, "wraps": ["c"]}, "axis that wraps c is unknown"),
    ],
)
def test_bad_noise_is_refused(noise: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        pair(**noise)
