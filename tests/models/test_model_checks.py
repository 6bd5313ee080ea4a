"""A model refuses parts that do not fit together: CasADi would broadcast them in silence."""

from __future__ import annotations

import dataclasses
from typing import Any

import casadi as ca
import numpy as np
import pytest

from models.errors import InputError
from models.gaussian import GaussianState
from models.pen import pen_model
from models.state_space import StateSpaceModel
from tests.models.pens import every_sensor, pen

PEN = pen_model(pen(6, every_sensor(np.random.default_rng(6))))
N = PEN.n_x


def constant_function(name: str, sizes: list[int], size: int) -> ca.Function:
    """Return a function of arguments of some sizes, with a result of a size."""
    arguments = [ca.SX.sym(f"a{k}", n) for k, n in enumerate(sizes)]
    return ca.Function(name, arguments, [ca.SX.zeros(size)])


SHORT = GaussianState(np.zeros(N - 1), np.eye(N))
NARROW = GaussianState(np.zeros(N), np.eye(N - 1))


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"state_units": ("m",)}, f"state_units has 1 entries, expected {N}"),
        ({"f": constant_function("f", [N - 1, N, 1], N)}, f"f's state has {N - 1} entries"),
        ({"f": constant_function("f", [N, N, 2], N)}, "f's step has 2 entries, expected 1"),
        ({"f": constant_function("f", [N, N, 1], N + 1)}, f"f's result has {N + 1} entries"),
        ({"prior": SHORT}, f"prior mean has {N - 1} entries, expected {N}"),
        ({"prior": NARROW}, f"prior covariance has {(N - 1) ** 2} entries, expected {N * N}"),
        ({"lower": np.zeros(3)}, f"lower has 3 entries, expected {N}"),
        ({"upper": np.zeros(3)}, f"upper has 3 entries, expected {N}"),
        ({"retract": constant_function("r", [N, N], 2)}, f"retract has 2 entries, expected {N}"),
        ({"difference": constant_function("d", [N, N], 2)}, "difference has 2 entries, expected"),
        ({"inequality": constant_function("g", [N + 1], 1)}, "inequality has"),
        ({"regularity": constant_function("m", [N], 2)}, "regularity has 2 entries, expected 1"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_shapes_are_checked(changes: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError) as error:
        PEN.replace(**changes)
    assert what in str(error.value)
    assert f"model {PEN.name}: " in str(error.value)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"h": constant_function("h", [N], 2)}, "accel: h has 2 entries, expected 3"),
        ({"axes": ("x", "y")}, "accel: h has 3 entries, expected 2"),
        ({"residual": constant_function("r", [3, N], 4)}, "accel: residual has 4 entries, expec"),
        ({"noise_std": np.ones(2)}, "accel: residual has 3 entries, expected 2"),
    ],
)
def test_shapes_of_sensors_are_checked(changes: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError, match=what):
        with_sensor(changes)


def with_sensor(changes: dict[str, Any]) -> StateSpaceModel:
    """Return the pen with its accelerometer changed."""
    return PEN.replace(sensors=(dataclasses.replace(PEN.sensor("accel"), **changes),))


@pytest.mark.parametrize(
    "changes",
    [
        {"h": constant_function("h", [N - 1], 3)},
        {"residual": constant_function("r", [4, N], 3)},
        {"residual": constant_function("r", [3, N - 1], 3)},
        {"unit_of_axis": ("m_s2",)},
        {"constant_reading": np.zeros(4)},
    ],
    ids=["h of x", "residual of y", "residual of x", "units", "constant reading"],
)
def test_arguments_of_sensors_are_checked(changes: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="accel"):
        with_sensor(changes)


@pytest.mark.parametrize("variance", [0.0, -1.0])
def test_prior_must_be_positive_definite(variance: float) -> None:
    covariance = np.eye(N)
    covariance[4, 4] = variance
    with pytest.raises(InputError, match="prior covariance is not positive definite") as error:
        PEN.replace(prior=GaussianState(np.zeros(N), covariance))
    assert PEN.name in str(error.value)


SKEWED = np.eye(N) + np.eye(N, k=1) / 2


@pytest.mark.parametrize(
    ("prior", "what"),
    [
        (GaussianState(np.zeros(N), np.diag(np.full(N, np.nan))), "covariance"),
        (GaussianState(np.full(N, np.nan), np.eye(N)), "mean"),
        (GaussianState(np.zeros(N), SKEWED), "covariance is not symmetric"),
        (GaussianState(np.zeros(N), np.eye(N).ravel()), "covariance has shape"),
    ],
    ids=["NaN covariance", "NaN mean", "not symmetric", "flat"],
)
def test_prior_must_be_a_gaussian(prior: GaussianState, what: str) -> None:
    with pytest.raises(InputError, match=f"prior {what}"):
        PEN.replace(prior=prior)
