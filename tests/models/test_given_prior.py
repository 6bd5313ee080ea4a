"""Priors as people give them: taken, or refused in a sentence that names what is wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from estimation.estimator import run
from estimation.recording import Recording
from models.errors import InputError
from models.gaussian import GaussianState
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator, settings_read

pytestmark = pytest.mark.usefixtures("interpreted")


def pair() -> StateSpaceModel:
    return own_model(
        "pair", {"a_m": (1.0, 0.5), "b_m": (-1.0, 2.0)}, lambda x, w, dt: x + dt**0.5 * w, 2,
        {"sum": OwnSensor(lambda x: x[0] + x[1], {"s": "m"}, 0.1)},
    )  # fmt: skip


def started(prior: Any, name: str = "ekf") -> GaussianState:
    """Return the first estimate, whose only reading is missing: what was known."""
    empty = Recording("empty", np.zeros(1), {"sum": np.full((1, 1), np.nan)})
    estimator = create_estimator(name, pair(), **settings_read(name, {"horizon": 2}))
    history = run(estimator, empty, prior=prior, covariances=True)
    return GaussianState(history.mean[0], history.covariance[0])


P = [[4.0, 1.0], [1.0, 9.0]]
TAKEN: dict[str, tuple[Any, list[float], Any]] = {
    "the model's": (None, [1.0, -1.0], np.diag([0.25, 4.0])),
    "lists": (GaussianState([3, 4], P), [3.0, 4.0], P),
    "pandas": (GaussianState(pd.Series([3, 4]), pd.DataFrame(P)), [3.0, 4.0], P),
    "a name": ({"b_m": (5, 0.1)}, [1.0, 5.0], np.diag([0.25, 0.01])),
    "names": ({"b_m": [5, 0.1], "a_m": np.array([2, 3])}, [2.0, 5.0], np.diag([9.0, 0.01])),
}  # fmt: skip


@pytest.mark.parametrize(
    ("case", "name"), [*((case, "ekf") for case in TAKEN), *(("names", n) for n in LEAST_SQUARES)]
)
def test_a_prior_is_taken(case: str, name: str) -> None:
    given, mean, covariance = TAKEN[case]
    found = started(given, name)
    np.testing.assert_allclose(found.mean, mean, rtol=1e-12)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-12)


REFUSED: dict[str, tuple[Any, str]] = {
    "a shape": (GaussianState(np.zeros(3), np.eye(2)), r"mean has shape \(3,\), expected \(2,\)"),
    "deviations": (
        GaussianState(np.zeros(2), np.ones(2)),
        r"the prior covariance has shape \(2,\), expected \(2, 2\)",
    ),
    "NaN": (GaussianState(np.array([0, np.nan]), np.eye(2)), "mean has entries that are not"),
    "infinite": (GaussianState(np.zeros(2), np.diag([1, np.inf])), "covariance has entries that"),
    "asymmetric": (GaussianState(np.zeros(2), np.array([[1, 0.5], [0, 1]])), "is not symmetric"),
    "known exactly": (GaussianState(np.zeros(2), np.diag([1.0, 0])), "is not positive definite"),
    "texts": (GaussianState(["a", "b"], P), "mean: list that holds no numbers, expected"),
    "another type": (([0, 0], P), "prior is of type tuple, expected a GaussianState or state"),
    "unknown": ({"c_m": (0, 1)}, "the prior's state c_m is unknown, expected one of a_m, b_m"),
    "too well known": ({"a_m": (0, 1e-300)}, "covariance is not positive definite"),
    "no deviation": ({"a_m": 1.0}, r"state a_m starts from 1.0, expected \(mean, positive"),
    "negative": ({"a_m": (0, -1)}, r"state a_m starts from \(0, -1\), expected \(mean, positive"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_prior_is_refused(case: str) -> None:
    given, sentence = REFUSED[case]
    with pytest.raises(InputError, match=f"model pair: .*{sentence}"):
        started(given)
