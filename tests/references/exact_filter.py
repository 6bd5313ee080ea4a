"""A Kalman filter's covariances in rational numbers, or in decimals of 60 digits."""

from __future__ import annotations

import decimal
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Matrix = list[list[Any]]
Number = Callable[[float], Any]
DIGITS = 60


def sixty_digits(value: float) -> decimal.Decimal:
    """A float as it is; what is made of it has `DIGITS` digits within `long_decimals`."""
    return decimal.Decimal(value)


def long_decimals() -> Any:
    """A context in which decimals keep `DIGITS` digits."""
    return decimal.localcontext(decimal.Context(prec=DIGITS))


def exact(matrix: Array, number: Number = Fraction) -> Matrix:
    """The same numbers, which floating point has exactly."""
    return [[number(float(x)) for x in row] for row in np.atleast_2d(matrix)]


def times(A: Matrix, B: Matrix) -> Matrix:
    columns = list(zip(*B, strict=True))
    return [[_dot(row, column) for column in columns] for row in A]


def predicted(P: Matrix, F: Array, G: Array, number: Number = Fraction) -> Matrix:
    """F P Fᵀ + G Gᵀ."""
    A, B = exact(F, number), exact(G, number)
    moved, noise = times(times(A, P), _turned(A)), times(B, _turned(B))
    return [[a + b for a, b in zip(p, q, strict=True)] for p, q in zip(moved, noise, strict=True)]


def updated(P: Matrix, H: Array, noise_std: Sequence[float], number: Number = Fraction) -> Matrix:
    """P given readings, one row of H (k, n) after the other."""
    for h, std in zip(exact(H, number), noise_std, strict=True):
        Ph = [_dot(row, h) for row in P]
        S = _dot(h, Ph) + number(float(std)) * number(float(std))
        P = [[p - a * b / S for p, b in zip(row, Ph, strict=True)]
             for row, a in zip(P, Ph, strict=True)]  # fmt: skip
    return P


def deviations(P: Matrix) -> Array:
    """Square roots of the diagonal (n,)."""
    return np.array([float(P[i][i]) for i in range(len(P))]) ** 0.5


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    products = [x * y for x, y in zip(a, b, strict=True) if x and y]
    return sum(products[1:], products[0]) if products else a[0] * 0


def _turned(A: Matrix) -> Matrix:
    return [list(column) for column in zip(*A, strict=True)]
