"""Matrices of a linear system as people give them: taken, or refused in a sentence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from models.arrays import Array, numbers
from models.errors import InputError
from models.gaussian import GaussianState
from models.given_prior import Known, Prior, given_prior
from models.names import several
from models.own_inputs import Inputs
from models.units import unit_ending

Matrix = float | Sequence[float] | Sequence[Sequence[float]] | Array
"""Also a pandas table. A number or a list is a matrix where only one fits: one row or column."""
Spread = tuple[Matrix, Matrix]
"""Mean (n_x,), and deviations (n_x,) or covariance (n_x, n_x); a number is the same for all."""

ROUNDING = 1e-9
"""Of the deviations of two states: how far their covariance may be from (semi-)definite."""


def matrix(where: str, what: str, given: Matrix, shape: tuple[int | None, int | None]) -> Array:
    """Return a matrix of finite numbers; a list is its only row or column, a number its only entry.

    Parameters
    ----------
    where, what : ``model cart``, ``A``
    shape : rows and columns, None where any number of them will do

    Raises
    ------
    InputError
        If it has another shape, or is not finite.
    """
    rows, columns = ("n" if size is None else str(size) for size in shape)
    expected = f"({rows}, {columns}) finite numbers"
    found = numbers(given, f"{where}: {what}", expected)
    if found.ndim == 1:
        # A list is a column where rows are given, as of B; a row where columns are, as of C.
        found = found[:, None] if shape[0] == len(found) != 1 else found[None, :]
    found = np.atleast_2d(found)
    fits = all(size in (None, n) for size, n in zip(shape, found.shape, strict=True))
    if found.ndim != 2 or not fits or not found.size:
        raise InputError(f"{where}: {what} has shape {np.shape(given)}, expected {expected}")
    if not np.isfinite(found).all():
        raise InputError(f"{where}: {what} has entries that are not finite, expected {expected}")
    return found


def covariance(where: str, what: str, given: Matrix, n: int, *, is_definite: bool = True) -> Array:
    """Return a covariance (n, n), a number being the same variance for all.

    Raises
    ------
    InputError
        If it has another shape, is not symmetric, or not positive (semi-)definite.
    """
    if np.ndim(given) == 0:
        given = np.eye(n) * numbers(given, f"{where}: {what}", "a number")
    P = matrix(where, what, given, (n, n))
    size = np.sqrt(np.abs(np.diag(P)))
    unit = np.where(size > 0, size, 1.0)  # an entry is judged in the units of its states
    correlation = P / np.outer(unit, unit)
    if np.abs(correlation - correlation.T).max() > ROUNDING:
        raise InputError(f"{where}: {what} is not symmetric, expected a covariance")
    P = np.asarray((P + P.T) / 2)
    least = float(np.linalg.eigvalsh((correlation + correlation.T) / 2).min())
    if least < -ROUNDING or (is_definite and least <= 0):
        kind = "definite" if is_definite else "semidefinite"
        raise InputError(f"{where}: {what} is not positive {kind}, expected a covariance")
    return P


def noise_density(where: str, Q: Matrix | None, G: Matrix | None, n_x: int) -> Array:
    """Return the covariance (n_x, n_x) of G w, w ~ N(0, Q); either may be left out.

    Raises
    ------
    InputError
        If both are, or one is no matrix of its shape.
    """
    if G is None:
        if Q is None:
            raise InputError(f"{where}: neither Q nor G, expected one (Q=0 has no noise)")
        return covariance(where, "Q", Q, n_x, is_definite=False)
    G = matrix(where, "G", G, (n_x, None))
    n_w = G.shape[1]
    inner = np.eye(n_w) if Q is None else covariance(where, "Q", Q, n_w, is_definite=False)
    return np.asarray(G @ inner @ G.T)


def names_of(where: str, what: str, given: Iterable[str], n: int, stem: str) -> tuple[str, ...]:
    """Return n names, numbered ones behind a stem where there are none.

    Raises
    ------
    InputError
        If there is another number of them, one is given twice or no text.
    """
    names = several(given) or tuple(f"{stem}{i + 1}" for i in range(n))
    if len(names) != n or len(set(names)) != n or not all(isinstance(s, str) for s in names):
        raise InputError(f"{where}: {what} are {names}, expected {n} different names")
    return names


def units_of(where: str, what: str, given: Inputs, n: int, stem: str) -> dict[str, str]:
    """Return name → unit of n quantities; a name without unit has the one that it ends in."""
    names = names_of(where, what, given, n, stem)
    if isinstance(given, Mapping):
        return dict(given)
    return {name: unit_ending(name) for name in names}


def first_state(
    model: str, states: tuple[str, ...], given: GaussianState | Known | Spread
) -> GaussianState:
    """Return what is known before the first reading.

    Parameters
    ----------
    model : its name
    states : (n_x,) names

    Raises
    ------
    InputError
        If a state is left out or unknown, a shape does not fit, or it is no Gaussian.
    """
    n_x, where = len(states), f"model {model}"
    none = GaussianState(np.zeros(n_x), np.eye(n_x))
    if isinstance(given, Mapping):
        for state in states:
            if state not in given:
                raise InputError(f"{where}: the prior has no {state}, expected every state")
    prior: Prior = _of_pair(where, given, n_x) if isinstance(given, tuple | list) else given
    return given_prior(model, states, none, prior)


def _of_pair(where: str, given: Sequence[Matrix], n_x: int) -> GaussianState:
    if len(given) != 2:
        raise InputError(
            f"{where}: the prior has {len(given)} parts, expected mean and deviations or covariance"
        )
    mean = numbers(given[0], f"{where}: the prior mean", f"({n_x},) numbers")
    spread = numbers(given[1], f"{where}: the prior's deviations", f"({n_x},) numbers")
    for what, values in (("mean", mean), ("deviations", spread)):
        if values.shape not in ((), (n_x,)) and not (what != "mean" and values.ndim == 2):
            raise InputError(
                f"{where}: the prior's {what} have shape {values.shape}, expected ({n_x},)"
            )
    if (spread <= 0).any() and spread.ndim < 2:
        raise InputError(f"{where}: the prior's deviations are {spread}, expected positive numbers")
    P = spread if spread.ndim == 2 else np.diag(np.broadcast_to(spread, (n_x,)) ** 2)
    return GaussianState(np.broadcast_to(mean, (n_x,)).copy(), np.asarray(P))
