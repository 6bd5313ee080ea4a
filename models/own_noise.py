"""The noise of a sensor of one's own: constant, or one that the model's inputs tell.

    r ~ N(0, R),   R = L Lᵀ

Rows that estimators see are independent. A constant R leaves them in their own units, those of
diag(std) L⁻¹ r. One that varies from reading to reading, R(u), is known with each reading: the
rows are L(u)⁻¹ r, in standard deviations (`SIGMA`) of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.names import unknown

SIGMA = "σ"
"""Unit of what is told in standard deviations of its own."""

Deviation = float | str | Sequence[float | str] | Array | Callable[[ca.SX], Any] | None
"""One for all rows or one each; a text is the name of an input, a function takes the inputs."""
Covariance = Sequence[Sequence[float]] | Array | Callable[[ca.SX], Any] | None


def varies(std: Deviation, covariance: Covariance) -> bool:
    """Return whether a noise depends on the model's inputs."""
    given = std if std is not None else covariance
    return callable(given) or any(isinstance(entry, str) for entry in np.ravel(_entries(given)))


def _entries(given: Any) -> Any:
    return np.array(given, dtype=object)


def constant_noise(
    name: str, std: Deviation, covariance: Covariance, n: int
) -> tuple[Array, Array | None]:
    """Return standard deviations (n,) and diag(std) L⁻¹ (n, n), None where R is diagonal.

    A shape that does not fit, or an R that is no covariance, raises `InputError`.
    """
    if std is not None:
        deviations = np.array(std, dtype=float)
        if deviations.shape not in ((), (n,)):
            raise _wrong_shape(name, deviations.shape, n)
        return np.broadcast_to(deviations, (n,)).copy(), None
    R = np.array(covariance, dtype=float)
    if R.shape != (n, n) or not np.allclose(R, R.T, rtol=1e-9, atol=0):
        raise _not_symmetric(name, R.shape, n)
    try:
        L = np.linalg.cholesky(R)
    except np.linalg.LinAlgError:
        raise InputError(f"sensor {name}: noise_covariance is not positive definite") from None
    deviations = np.sqrt(np.diag(R))
    return deviations, np.tril(deviations[:, None] * np.linalg.inv(L))


def whitened(
    name: str, r: ca.SX, std: Deviation, covariance: Covariance, inputs: dict[str, ca.SX]
) -> ca.SX:
    """Return the rows L(u)⁻¹ r (n,), in standard deviations, of a noise that varies.

    A row whose deviation is not above zero says nothing.

    Parameters
    ----------
    inputs : name → symbol, of the model's inputs

    Raises
    ------
    InputError
        If an input is unknown, or a shape does not fit.
    """
    n = r.numel()
    L = _factor(name, covariance, n, inputs) if std is None else ca.diag(_std(name, std, n, inputs))
    rows: list[ca.SX] = []
    for i in range(n):
        left = r[i] - sum((L[i, j] * rows[j] for j in range(i) if L[i, j].nnz()), ca.SX(0))
        rows.append(ca.if_else(L[i, i] > 0, left / L[i, i], 0))
    return ca.vertcat(*rows)


def _std(name: str, std: Deviation, n: int, inputs: dict[str, ca.SX]) -> ca.SX:
    if callable(std):
        found = ca.densify(ca.SX(std(_stacked(name, inputs))))
    else:
        entries = np.ravel(_entries(std))
        for entry in entries:
            if isinstance(entry, str) and entry not in inputs:
                raise unknown(f"sensor {name}: noise_std is the input", entry, inputs)
        found = ca.vertcat(*(inputs[e] if isinstance(e, str) else ca.SX(e) for e in entries))
    if found.shape not in ((1, 1), (n, 1)):
        raise _wrong_shape(name, found.shape, n)
    return ca.repmat(found, n // found.numel(), 1)


def _factor(name: str, covariance: Covariance, n: int, inputs: dict[str, ca.SX]) -> ca.SX:
    """Return L (n, n) of R(u), its lower triangle."""
    assert callable(covariance)
    u = _stacked(name, inputs)
    R = ca.densify(ca.SX(covariance(u)))
    if R.shape != (n, n):
        raise _not_symmetric(name, R.shape, n)
    at_ones = ca.Function("R", [u], [R])(np.ones(u.numel())).full()
    if not np.allclose(at_ones, at_ones.T, rtol=1e-9, atol=0, equal_nan=True):
        raise _not_symmetric(name, R.shape, n)
    L = ca.SX(n, n)
    for j in range(n):
        for i in range(j, n):
            left = R[i, j] - sum((L[i, k] * L[j, k] for k in range(j)), ca.SX(0))
            L[i, j] = ca.sqrt(left) if i == j else left / L[j, j]
    return L


def _stacked(name: str, inputs: dict[str, ca.SX]) -> ca.SX:
    if not inputs:
        raise InputError(
            f"sensor {name}: its noise is a function of inputs and the model has none, "
            "expected a number or inputs=…"
        )
    return ca.vertcat(*inputs.values())


def _wrong_shape(name: str, shape: tuple[int, ...], n: int) -> InputError:
    return InputError(f"sensor {name}: noise_std has shape {shape}, expected ({n},)")


def _not_symmetric(name: str, shape: tuple[int, ...], n: int) -> InputError:
    return InputError(f"sensor {name}: noise_covariance {shape}, expected symmetric ({n}, {n})")
