"""What is known before the first measurement, as people give it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from models.arrays import Array, numbers
from models.errors import InputError
from models.gaussian import GaussianState
from models.model_checks import check_prior
from models.names import unknown
from models.plain_names import check_text

Known = Mapping[str, tuple[float, float]]
"""Name → mean and standard deviation."""
Prior = GaussianState | Known
"""Mean and covariance of all states, or of some states by name."""


def known_values(model: str, kind: str, known: Known) -> tuple[Array, Array]:
    """Return means and standard deviations (n,) of quantities given by name.

    Parameters
    ----------
    model : its name
    kind : of what is named: ``state``

    Raises
    ------
    InputError
        If one is no pair of a finite mean and a positive standard deviation.
    """
    if not isinstance(known, Mapping):
        raise InputError(
            f"model {model}: {kind}s are {known!r}, "
            "expected name → (mean, positive standard deviation)"
        )
    pairs = np.zeros((len(known), 2))
    for i, (name, pair) in enumerate(known.items()):
        try:
            pairs[i] = np.array(pair, dtype=float)
            is_good = np.shape(pair) == (2,) and np.isfinite(pairs[i]).all() and pairs[i, 1] > 0
        except (TypeError, ValueError):
            is_good = False
        if not is_good or not isinstance(name, str):
            raise InputError(
                f"model {model}: {kind} {name} starts from {pair}, "
                "expected (mean, positive standard deviation)"
            )
        check_text(name, f"model {model}: {kind}")
    return pairs[:, 0], pairs[:, 1]


def given_prior(
    model: str, states: tuple[str, ...], usual: GaussianState, given: Prior
) -> GaussianState:
    """Return a prior as a person gives it, its covariance symmetric to the last bit.

    Parameters
    ----------
    model : its name
    states : (n_x,) names
    usual : what is known of states that a mapping does not name; those that it names are
        independent of all others
    given : mean and covariance of all states, or state → mean and standard deviation

    Raises
    ------
    InputError
        If it is neither, a state is unknown, a shape disagrees, or it is not finite, symmetric
        and positive definite.
    """
    if isinstance(given, Mapping):
        return _by_name(model, states, usual, given)
    if not isinstance(given, GaussianState):
        raise InputError(
            f"model {model}: the prior is {_shortly(given)}, expected a GaussianState or "
            "state → (mean, positive standard deviation)"
        )
    n_x, where = len(states), f"model {model}: the prior"
    mean = numbers(given.mean, f"{where} mean", f"({n_x},) numbers")
    covariance = numbers(given.covariance, f"{where} covariance", f"({n_x}, {n_x}) numbers")
    check_prior(model, GaussianState(mean, covariance), n_x, is_definite=given.root is None)
    symmetric = np.asarray((covariance + covariance.T) / 2)
    return replace(given, mean=mean, covariance=symmetric)


def _by_name(
    model: str, states: tuple[str, ...], usual: GaussianState, given: Known
) -> GaussianState:
    for name in given:
        if name not in states:
            raise unknown(f"model {model}: the prior's state", name, states)
    means, stds = known_values(model, "state", given)
    mean, covariance = usual.mean.copy(), usual.covariance.copy()
    index = [states.index(name) for name in given]
    mean[index] = means
    covariance[index, :] = 0.0
    covariance[:, index] = 0.0
    covariance[index, index] = stds**2
    found = GaussianState(mean, np.asarray(covariance))
    check_prior(model, found, len(states))
    return found


def _shortly(given: Any) -> str:
    return "None" if given is None else f"of type {type(given).__name__}"
