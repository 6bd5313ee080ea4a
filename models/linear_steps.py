"""A linear system over a step of any length: its transition and process noise, as functions of Δt.

Continuous, with white noise of density Q:

    d/dt x = A x + …   →   F(Δt) = e^{A Δt},   Q(Δt) = ∫₀^Δt e^{A s} Q e^{Aᵀ s} ds

by the series over Δt / 2^k, short enough for it, and k doublings. Discrete, of steps of T seconds:
Δt is a whole number of them, and every one is made. Both are one rule, two parts of a step:

    F = F₂ F₁,   Q = F₂ Q₁ F₂ᵀ + Q₂

References
----------
Osborne (1960), On pre-conditioning of matrices, Journal of the ACM 7(4).
Van Loan (1978), Computing integrals involving the matrix exponential, IEEE Trans. Automatic
Control 23(3).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from models.arrays import Array

LONGEST_NORM = 0.5
"""Of A Δt in one step of the series."""
TERMS = 20
"""Of the series: (2 · LONGEST_NORM)^TERMS / TERMS! is below rounding."""
DOUBLINGS = 24
"""A gap of more than 2^this steps, of the series or of T, is NaN."""
SWEEPS = 100
"""Over all states, to balance their units; a handful are enough."""
INTERVAL_TOLERANCE = 0.05
"""Of T: how far a time between two readings may be from a whole number of discrete steps."""
ROUNDING = 1e-15
"""Of a variance: what is left of it below that is no noise."""


def continuous_steps(A: Array, Q: Array) -> ca.Function:
    """Return Δt → F (n, n), Q (n, n) of a continuous system A, Q (n, n).

    The series is that of the states in units in which A is balanced: in units that lie far apart
    its norm would ask for more doublings than there are, and each would lose digits.
    """
    unit = balanced_units(A)
    A, Q = A * np.outer(1 / unit, unit), Q / np.outer(unit, unit)
    h, n = ca.MX.sym("h"), len(A)
    F, noise = ca.MX(ca.DM.eye(n)), ca.MX(n, n)
    power, change, factor = np.eye(n), Q, h
    for i in range(1, 2 * n + TERMS):
        noise = noise + factor * ca.DM(change)  # factor is hⁱ / i!
        power, change = power @ A, A @ change + change @ A.T
        F = F + factor * ca.DM(power)
        factor = factor * h / (i + 1)
        if i >= TERMS or not (power.any() or change.any()):
            break
    once = _called("series", [h], [F, ca.densify(noise)])
    norm = float(np.abs(A).sum(axis=0).max(initial=0.0))
    if not (power.any() or change.any()):  # A is nilpotent, its series ends: exact for every Δt
        return _in_units(once, unit)
    repeated = [once]
    for _ in range(DOUBLINGS):
        half = _pair(repeated[-1](h / 2))
        repeated.append(_called("doubled", [h], _joined(half, half)))
    k = ca.ceil(ca.log(ca.fmax(h * (norm / LONGEST_NORM), 1.0)) / np.log(2.0) - 1e-9)
    return _in_units(_branch([*repeated, _called("none", [h], _nothing(n))], k, h), unit)


def balanced_units(A: Array) -> Array:
    """Return units of the states (n,), powers of two, in which no row or column of A is large.

    Osborne's method. To what a state takes from others and gives to them the size of A is added,
    that of its largest pole: a state that takes nothing, an input, would have no unit.
    """
    size, unit, between = np.abs(np.linalg.eigvals(A)).max(), np.ones(len(A)), np.abs(A)
    np.fill_diagonal(between, size)
    for _ in range(SWEEPS if size > 0 else 0):
        before = unit.copy()
        for i in range(len(A)):
            given, taken = between[:, i].sum(), between[i].sum()
            factor = 2.0 ** np.round(np.log2(taken / given) / 2)
            unit[i] *= factor
            between[:, i] *= factor
            between[i] /= factor
        if (unit == before).all():
            break
    return unit


def _in_units(steps: ca.Function, unit: Array) -> ca.Function:
    """Return Δt → F, Q of states that are `unit` (n,) times those of a function."""
    if (unit == 1).all():
        return steps
    dt = ca.MX.sym("dt")
    F, Q = _pair(steps(dt))
    own = [ca.DM(np.outer(unit, 1 / unit)) * F, ca.DM(np.outer(unit, unit)) * Q]
    return _called("in_units", [dt], own)


def discrete_steps(A: Array, Q: Array, interval_s: float) -> ca.Function:
    """Return Δt → F (n, n), Q (n, n) of a discrete system A, Q (n, n) of steps of a fixed time.

    They are NaN where Δt is no whole number of steps, within `INTERVAL_TOLERANCE`.
    """
    dt, n = ca.MX.sym("dt"), len(A)
    constants = A, Q
    before = ca.MX.sym("F", n, n), ca.MX.sym("Q", n, n)
    made = _called("made", before, before)
    steps = ca.floor(dt / interval_s + 0.5)
    found, left = (ca.MX(ca.DM.eye(n)), ca.MX(ca.DM.zeros(n, n))), steps
    for _ in range(DOUBLINGS):
        more = _called("more", before, _joined(before, (ca.MX(ca.DM(A)), ca.MX(ca.DM(Q)))))
        halved = ca.floor(left / 2)
        bit = ca.Function.conditional("bit", [made], more)
        found = _pair(bit(left - 2 * halved, *found))
        with np.errstate(over="ignore", invalid="ignore"):  # of an unstable system, in time
            A, Q, left = A @ A, A @ Q @ A.T + Q, halved
        if not np.isfinite([A, Q]).all():
            break
    many = _called("many", [dt], found)
    one = _called("one", [dt], [ca.MX(ca.DM(first)) for first in constants])
    is_whole = ca.logic_and(ca.fabs(dt / interval_s - steps) <= INTERVAL_TOLERANCE, left == 0)
    case = ca.if_else(is_whole, ca.if_else(steps == 1, 0, 1), 2)
    return _branch([one, many, _called("none", [dt], _nothing(n))], case, dt)


def step_matrix(steps: ca.Function, n_x: int, moved: Sequence[int]) -> ca.Function:
    """Return Δt → J (n_x, n + n_w), the next x being J (x, what stays, w), as one call.

    Parameters
    ----------
    steps : Δt → F (n, n), Q (n, n)
    n_x : states, the first of n; the others stay
    moved : (n_w,) indices of states that noise moves; L Lᵀ is their covariance, J = (F, L)
    """
    dt, covariance = ca.MX.sym("dt"), ca.SX.sym("Q", len(moved), len(moved))
    factor = ca.Function("factor", [covariance], [ca.densify(noise_factor(covariance))])
    F, Q = _pair(steps(dt))
    L = factor(Q[list(moved), list(moved)]) if moved else ca.MX(0, 0)
    J = ca.densify(ca.horzcat(F[:n_x, :], ca.DM(np.eye(n_x)[:, list(moved)]) @ L))
    # Nobody asks how a step changes with Δt, and the root of a variance of zero has no slope.
    # CasADi looks at the zeros given here only where J depends on Δt: so it does, by nothing.
    J = J + ca.fmin(ca.fabs(dt), 0)
    slopes = [ca.MX(ca.DM.zeros(J.numel(), 1))]
    given = [dt, ca.MX.sym("J", J.shape[0], J.shape[1])]
    options: Any = {
        "never_inline": True,
        "custom_jacobian": ca.Function("jac_matrix", given, slopes),
    }
    return ca.Function("matrix", [dt], [J], options)


def noise_factor(Q: ca.SX) -> ca.SX:
    """Return L (n, n), L Lᵀ = Q, lower, of a covariance that may be singular or zero."""
    n = Q.shape[0]
    L = ca.SX(n, n)
    for j in range(n):
        pivot = Q[j, j] - sum((L[j, k] ** 2 for k in range(j)), ca.SX(0))
        is_noise = pivot > ROUNDING * Q[j, j]
        # What is not defined stays NaN.
        L[j, j] = ca.if_else(is_noise, ca.sqrt(pivot), ca.if_else(ca.fabs(pivot) >= 0, 0, pivot))
        for i in range(j + 1, n):
            left = Q[i, j] - sum((L[i, k] * L[j, k] for k in range(j)), ca.SX(0))
            L[i, j] = ca.if_else(is_noise, left / L[j, j], 0)
    return L


def _joined(first: Sequence[ca.MX], second: Sequence[ca.MX]) -> list[ca.MX]:
    """Return F, Q of one step and another behind it."""
    (F1, Q1), (F2, Q2) = first, second
    return [F2 @ F1, F2 @ Q1 @ F2.T + Q2]


def _pair(results: Any) -> tuple[ca.MX, ca.MX]:
    """Return the two results of a call: how many there are, the types do not say."""
    first, second = results
    return first, second


def _branch(cases: Sequence[ca.Function], index: ca.MX, dt: ca.MX) -> ca.Function:
    """Return one of several functions of Δt; the last where the index is beyond."""
    branch = ca.Function.conditional("branch", list(cases[:-1]), cases[-1])
    return _called("matrices", [dt], _pair(branch(index, dt)))


def _nothing(n: int) -> list[ca.MX]:
    return [ca.MX(ca.DM(np.full((n, n), np.nan)))] * 2


def _called(name: str, arguments: Sequence[ca.MX], results: Sequence[ca.MX]) -> ca.Function:
    """Return a function that stays one: written out, repeated steps would double the code."""
    return ca.Function(name, list(arguments), list(results), {"never_inline": True})
