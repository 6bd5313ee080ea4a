"""Whether any state meets a model's bounds and inequalities at all.

Rows of the inequality that are affine in the state, and the bounds, are a
linear program:

    a_i · x + b_i ≤ 0   for every affine row i,   lower ≤ x ≤ upper

A row that only instants with certain readings demand has a program of its own, with all
rows that such an instant demands in any case: those with the same conditions or fewer. Two
rows with different conditions may contradict each other, as no instant need ever demand
both. Where one does, and for rows that are not affine, the solver says `INFEASIBLE` while
it runs.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import TypeVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.errors import InputError

ModelT = TypeVar("ModelT")

LINPROG_INFEASIBLE = 2
"""`scipy.optimize.linprog`'s status for a problem that no point solves."""

_ARITHMETIC = frozenset(
    {
        ca.OP_INPUT,
        ca.OP_OUTPUT,
        ca.OP_CONST,
        ca.OP_ASSIGN,
        ca.OP_ADD,
        ca.OP_SUB,
        ca.OP_MUL,
        ca.OP_DIV,
        ca.OP_NEG,
        ca.OP_TWICE,
    }
)
"""Operations of which a constant Jacobian makes an affine function.

A step has a constant Jacobian too, but it takes a comparison to write one.
"""


@dataclass(frozen=True, eq=False)
class Constraints:
    """What a model demands of its states; fields as of `models.state_space.StateSpaceModel`."""

    name: str
    state_names: tuple[str, ...]
    lower: Array
    upper: Array
    inequality: ca.Function
    inequality_needs: NDArray[np.bool_]
    reading_names: tuple[str, ...]


def check_feasible(model: Constraints) -> None:
    """Refuse bounds and affine inequalities of a model that no state meets.

    A conflict smaller than HiGHS's tolerance (1e-7, of rows scaled to a largest
    coefficient of 1) passes.

    Raises
    ------
    InputError
        If no state meets those of some instant; the message names a smallest set of rows
        that cannot be met, counted from 1, and the bounds that take part.
    """
    x = ca.vertcat(*(ca.SX.sym(name) for name in model.state_names))
    rows = ca.vertcat(model.inequality(x))
    A, b = _affine_rows(rows, x)
    needs = model.inequality_needs
    # Fewest conditions first: a conflict is told with the fewest rows.
    patterns = {tuple(needs[row].tolist()) for row in A}
    for pattern in sorted(patterns, key=lambda pattern: (sum(pattern), pattern)):
        needed = np.array(pattern, dtype=bool)
        demanded = [row for row in A if not (needs[row] & ~needed).any()]
        if not _is_feasible(A, b, demanded, model.lower, model.upper):
            raise _refusal(model, rows, A, b, demanded)


def feasible(model: ModelT) -> ModelT:
    """Return a state-space model, unless no state meets its constraints; see `check_feasible`."""
    own = {field: getattr(model, field) for field in Constraints.__annotations__}
    check_feasible(Constraints(**own))
    return model


def _refusal(
    model: Constraints,
    texts: ca.SX,
    A: dict[int, Array],
    b: dict[int, float],
    demanded: list[int],
) -> InputError:
    """Return what to say of rows that no state meets: a smallest set of them, with bounds."""
    lower, upper = model.lower.copy(), model.upper.copy()
    conflict = list(demanded)
    for row in demanded:
        others = [other for other in conflict if other != row]
        if not _is_feasible(A, b, others, lower, upper):
            conflict = others
    bounded = np.flatnonzero(np.isfinite(lower) | np.isfinite(upper))
    for state in bounded:
        kept = lower[state], upper[state]
        lower[state], upper[state] = -np.inf, np.inf
        if _is_feasible(A, b, conflict, lower, upper):
            lower[state], upper[state] = kept
    demands = [
        f"row {row + 1} of the inequality ({texts[row]} <= 0{_condition(model, row)})"
        for row in conflict
    ]
    demands += [
        f"the bound on {model.state_names[state]} ({lower[state]:g} to {upper[state]:g})"
        for state in bounded
        if np.isfinite(lower[state]) or np.isfinite(upper[state])
    ]
    return InputError(
        f"model {model.name}: no state meets {' and '.join(demands)}, "
        "expected constraints that some state meets"
    )


def _condition(model: Constraints, row: int) -> str:
    """Say which readings make an instant demand a row: `` where there is contact_z``."""
    names = np.array(model.reading_names)[model.inequality_needs[row]]
    return f" where there is {' and '.join(names)}" if len(names) else ""


def _affine_rows(rows: ca.SX, x: ca.SX) -> tuple[dict[int, Array], dict[int, float]]:
    """Return a_i (n_x,) and b_i of every affine row i, scaled to a largest |a_ij| of 1."""
    A, b = {}, {}
    for row in range(rows.numel()):
        g = ca.Function("g", [x], [ca.densify(rows[row])])
        operations = {g.instruction_id(k) for k in range(g.n_instructions())}
        if not operations <= _ARITHMETIC or any(ca.which_depends(rows[row], x, 2, True)):
            continue
        a = np.asarray(g.jacobian()(np.zeros(x.numel()), 0)).ravel()
        at_zero = float(g(np.zeros(x.numel())))
        scale = np.abs(a).max(initial=0.0) or abs(at_zero) or 1.0
        if np.isfinite(scale) and np.isfinite(at_zero):
            A[row], b[row] = a / scale, at_zero / scale
    return A, b


def _is_feasible(
    A: dict[int, Array], b: dict[int, float], rows: Collection[int], lower: Array, upper: Array
) -> bool:
    if not rows:
        return True
    from scipy.optimize import linprog  # 0.2 s to import, for constrained models only

    result = linprog(
        np.zeros(len(lower)),
        A_ub=np.array([A[row] for row in rows]),
        b_ub=-np.array([b[row] for row in rows]),
        bounds=list(zip(lower, upper, strict=True)),
    )
    return bool(result.status != LINPROG_INFEASIBLE)
