"""Sums in the order in which C makes them, in symbols: so both round alike.

What is zero adds nothing and what is one multiplies nothing, so that all rows can be written down
where C (estimation/covariance_stage.c) leaves those out that are not present.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from models.arrays import Array


def unit_rows(F: ca.SX) -> list[int]:
    """Return 1 for each row of a square F whose diagonal is the number one, else 0."""
    return [int(F[i, i].is_one()) for i in range(F.size1())]


def product(
    F: ca.SX, rows: ca.SX, *, more: ca.SX | None = None, unit: Sequence[int] | None = None
) -> ca.SX:
    """Return F rows + more (n, m): ones on the diagonal first, then each row from the left.

    Parameters
    ----------
    unit : `unit_rows` of F, where F itself is symbols
    """
    found, unit = [], unit_rows(F) if unit is None else unit
    for i in range(F.size1()):
        pattern = F[i, :].sparsity()
        columns = pattern.get_col()
        total = rows[i, :] if unit[i] else ca.SX.zeros(1, rows.size2())
        total = total if more is None else total + more[i, :]
        for k in columns:
            if not (unit[i] and k == i):
                total = total + F[i, k] * rows[k, :]
        found.append(total)
    return ca.vertcat(*found)


def less(value: ca.SX, A: ca.SX, x: ca.SX) -> ca.SX:
    """Return value - A x (n,), each product taken away by itself."""
    found = []
    for i in range(A.size1()):
        left = value[i]
        for k in A[i, :].sparsity().get_col():
            left = left - A[i, k] * x[k]
        found.append(left)
    return ca.vertcat(ca.SX(0, 1), *found)


def whitened(H: ca.SX, P: ca.SX, v: ca.SX, noise_std: Array) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return L (n_r, n_r), L Lᵀ = H P Hᵀ + R, and row by row Wᵀ = L⁻¹ H P (n_r, n_x), e = L⁻¹ v."""
    n_r, n_x = H.shape
    L, W, e = ca.SX(n_r, n_r), ca.SX(0, n_x), ca.SX(0, 1)
    for r in range(n_r):
        columns = H[r, :].sparsity().get_col()
        row = ca.SX.zeros(1, n_x)
        for k in columns:
            row = row + H[r, k] * P[k, :]
        square, left = ca.SX(float(noise_std[r]) * float(noise_std[r])), v[r]
        for k in columns:
            square = square + H[r, k] * row[k]
        for q in range(r):
            entry = ca.SX(0)
            for k in columns:
                entry = entry + H[r, k] * W[q, k]
            L[r, q] = entry
            square = square - entry * entry
            left = left - entry * e[q]
        for q in range(r):
            row = row - L[r, q] * W[q, :]
        length = ca.sqrt(square)
        L[r, r] = length
        by = ca.fabs(1 / length)  # a factor of 1 / length alone would become a division
        W, e = ca.vertcat(W, row * by), ca.vertcat(e, left * by)
    return L, W, e


def dot(a: ca.SX, b: ca.SX) -> ca.SX:
    """Return aᵀ b of columns, by four sums side by side as estimation/arrays.c has it."""
    sums, n = [ca.SX(0)] * 4, a.numel()
    for i in range(n):
        j = i % 4 if i < n // 4 * 4 else 0
        sums[j] = sums[j] + a[i] * b[i]
    return (sums[0] + sums[1]) + (sums[2] + sums[3])
