"""Whether the parts of a state-space model fit together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.errors import InputError
from models.gaussian import GaussianState
from models.names import expected_one_of
from models.sensor_model import SensorModel


def input_sizes(
    what: str, function: ca.Function, first: int, expected: Sequence[int]
) -> dict[str, tuple[int, int]]:
    """Return the sizes, as `check_sizes` takes them, of a function's arguments from `first` on."""
    found = [function.numel_in(i) for i in range(first, function.n_in())]
    sizes = {f"{what}'s inputs": (len(found), len(expected))}
    if len(found) == len(expected):
        pairs = enumerate(zip(found, expected, strict=True), 1)
        sizes |= {f"{what}'s input {i}": pair for i, pair in pairs}
    return sizes


def check_sizes(
    model: str,
    sizes: Mapping[str, tuple[int, int]],
    sensors: Iterable[SensorModel],
    n_x: int,
    *,
    n_u: int = 0,
) -> None:
    """Raise `InputError` with the first part whose size does not fit, or a noise of zero.

    Parameters
    ----------
    model : its name
    sizes : part → the entries it has, the entries expected
    """
    expected = dict(sizes)
    for sensor in sensors:
        expected[f"{sensor.name}: h"] = (sensor.h.numel_out(0), sensor.n_y)
        expected[f"{sensor.name}: residual"] = (sensor.residual.numel_out(0), sensor.n_r)
        expected[f"{sensor.name}: h's state"] = (sensor.h.numel_in(0), n_x)
        expected[f"{sensor.name}: residual's reading"] = (sensor.residual.numel_in(0), sensor.n_y)
        expected[f"{sensor.name}: residual's state"] = (sensor.residual.numel_in(1), n_x)
        inputs = (n_u,) if sensor.reads_inputs else ()
        expected |= input_sizes(f"{sensor.name}: h", sensor.h, 1, inputs)
        expected |= input_sizes(f"{sensor.name}: residual", sensor.residual, 2, inputs)
        expected[f"{sensor.name}: unit_of_axis"] = (len(sensor.unit_of_axis), sensor.n_y)
        expected[f"{sensor.name}: unit_of_row"] = (len(sensor.unit_of_row), sensor.n_r)
        if sensor.constant_reading is not None:
            size = sensor.constant_reading.size
            expected[f"{sensor.name}: constant_reading"] = (size, sensor.n_y)
        if not (np.isfinite(sensor.noise_std) & (sensor.noise_std > 0)).all():
            raise InputError(
                f"model {model}: noise_std of {sensor.name} is {sensor.noise_std}, "
                "expected positive numbers"
            )
    for what, (size, wanted) in expected.items():
        if size != wanted:
            raise InputError(f"model {model}: {what} has {size} entries, expected {wanted}")


def check_conditions(model: str, conditions: NDArray[np.bool_], rows: tuple[int, int]) -> None:
    """Raise `InputError` unless conditions are Booleans: rows of the inequality, readings."""
    if conditions.shape != rows or conditions.dtype != np.bool_:
        raise InputError(
            f"model {model}: conditions have shape {conditions.shape} of "
            f"{conditions.dtype}, expected {rows} of bool: rows of the inequality, readings"
        )


def check_prior(model: str, prior: GaussianState, n_x: int, *, is_definite: bool = True) -> None:
    """Raise `InputError` unless a prior is finite, symmetric and positive definite.

    Parameters
    ----------
    is_definite : false where a root of the covariance says what rounding took from it
    """
    mean, covariance = prior.mean, prior.covariance
    for what, array, shape in (("mean", mean, (n_x,)), ("covariance", covariance, (n_x, n_x))):
        if array.shape != shape:
            raise InputError(
                f"model {model}: the prior {what} has shape {array.shape}, expected {shape}"
            )
        if not np.isfinite(array).all():
            raise InputError(f"model {model}: the prior {what} has entries that are not finite")
    asymmetry = np.abs(covariance - covariance.T)
    if (asymmetry > 1e-9 * np.abs(covariance).max()).any():
        raise InputError(f"model {model}: the prior covariance is not symmetric, expected P = Pᵀ")
    try:
        if is_definite:
            np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        raise InputError(
            f"model {model}: the prior covariance is not positive definite, "
            "expected positive variances and correlations between -1 and 1"
        ) from None


def check_bound(
    model: str, state_names: tuple[str, ...], state: str, bound: tuple[float, float]
) -> None:
    """Raise `InputError` unless a bound is on a known state, its lower end below the upper."""
    low, high = bound
    if state not in state_names:
        raise InputError(
            f"model {model}: bound on unknown state {state}; {expected_one_of(state, state_names)}"
        )
    if not low < high:
        raise InputError(
            f"model {model}: bound on {state}: lower {low} is not below upper {high}, "
            "expected lower < upper"
        )


def check_needs(model: str, reading_names: tuple[str, ...], needs: tuple[str, ...]) -> None:
    """Raise `InputError` unless every reading that an inequality needs is known."""
    for name in needs:
        if name not in reading_names:
            raise InputError(
                f"model {model}: an inequality needs the unknown reading {name}; "
                f"{expected_one_of(name, reading_names)}"
            )
