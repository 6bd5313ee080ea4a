"""Bounds on the states of a model of one's own, against the constrained least squares of SciPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from estimation.estimator import run
from estimation.recording import Recording
from models.errors import InputError
from models.own_models import OwnSensor, own_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator

STD, READ_STD, WALK = 0.5, 0.1, 0.3
LEVELS = (0.05, -0.2, -0.1, 0.3, -0.25)
"""Of a level that cannot be negative: three readings are."""


def tank(bounds: Any = None) -> StateSpaceModel:
    sensors = {"float": OwnSensor(lambda x: x[0], {"h": "m"}, READ_STD, 10.0)}
    return own_model(
        "tank",
        {"level_m": (0.2, STD)},
        lambda x, w, dt: x + WALK * dt**0.5 * w,
        1,
        sensors,
        bounds=bounds,
    )


def recording() -> Recording:
    return Recording("tank", 0.1 * np.arange(len(LEVELS)), {"float": np.array(LEVELS)[:, None]})


def bounded_optimum(n: int) -> float:
    """Return the newest of n levels ≥ 0 that fit the readings, the walk and the prior best."""
    walk = np.diff(np.eye(n), axis=0) / (WALK * 0.1**0.5)
    rows = np.vstack([np.eye(1, n) / STD, walk, np.eye(n) / READ_STD])
    wanted = np.concatenate([[0.2 / STD], np.zeros(n - 1), np.array(LEVELS[:n]) / READ_STD])
    return float(lsq_linear(rows, wanted, (0.0, np.inf), tol=1e-14).x[-1])


@pytest.mark.parametrize("bound", [(0.0, None), [0, np.inf], (0.0, 5.0)])
def test_a_bound_is_in_the_model(bound: Any) -> None:
    model = tank({"level_m": bound})
    assert model.lower.tolist() == [0.0]
    assert model.upper.tolist() == [5.0 if bound[1] == 5.0 else np.inf]
    assert np.isinf([*tank().lower, *tank({"level_m": (None, None)}).lower]).all()


@pytest.mark.parametrize("name", ["mhe", "mhe-rti", "mhe-ipopt"])
@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
def test_estimates_are_the_bounded_optimum(
    name: str, engine: str, request: pytest.FixtureRequest
) -> None:
    """To what IPOPT's barrier leaves near an active bound."""
    if engine == "interpreted":
        request.getfixturevalue("interpreted")
    model = tank({"level_m": (0.0, None)})
    history = run(create_estimator(name, model, horizon=10), recording())
    wanted = [bounded_optimum(n + 1) for n in range(len(LEVELS))]
    assert min(wanted) < 1e-9 < max(wanted)
    np.testing.assert_allclose(history.mean[:, 0], wanted, rtol=0, atol=2e-6)


@pytest.mark.parametrize(
    ("bounds", "sentence"),
    [
        ({"level": (0, 1)}, "bound on unknown state level; expected one of level_m; did you mean"),
        ({"level_m": (1, 0)}, "lower 1.0 is not below upper 0.0, expected lower < upper"),
        ({"level_m": 0.0}, r"bound on level_m is 0.0, expected \(lower, upper\), None where"),
        ({"level_m": ("a", 1)}, r"bound on level_m is \('a', 1\), expected \(lower, upper\)"),
    ],
)
def test_a_bad_bound_is_refused(bounds: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        tank(bounds)
