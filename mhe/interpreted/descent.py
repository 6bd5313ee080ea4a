"""Descent to a window's optimum: Gauss-Newton steps that cannot diverge.

The unknown is z = (μ, w_0, w_1, …), which fixes the trajectory: x_0 = x̄ ⊞ P̄ μ, then the
model. A pass at z returns the linearised window's optimum g and the squared length of the
step g - z in units of the whitened problem, in which the Hessian is at least the identity.

1. *Line search.* The step is halved until the cost J falls by at least ``SUFFICIENT`` times
   what its slope promises (Armijo). J never rises, and it holds ½‖w‖²: no iterate can
   leave for infinity.
2. *Anderson acceleration.* Where curvature and residual are large, Gauss-Newton converges
   slowly and linearly. Below a length of ``GATE`` standard deviations the last three points
   propose a further one, taken only if J falls enough for a full step.
3. *Settling.* Where the fall that a step promises is below ``RESOLUTION`` · J, the cost
   cannot judge it any more. Then a step is kept if the step after it is shorter, else it
   is halved.

5. *Constraints.* Bounds and inequalities hold at g, a linearised optimum that meets their rows
   (`mhe.interpreted.active_set`). The line search judges J + Σ ρ · violation, with weights ρ above
   every multiplier so far (at least twice it): its slope is then at least as steep as J's without
   them. Where the rows curve, this merit may refuse good full steps (Maratos effect): below
   `GATE` such a step is taken and settled as in 3. Points are forgotten when the set changes.

It ends with a step shorter than the tolerance, or one that the next would follow with less, going
by the worse of the last two ratios of lengths (solved); or where halving does not help any
more: solved, if the step is shorter than ``FLOOR``, the accuracy that rounding allows.

4. *Unwinding.* A deviation from the prior may have gone round a whole turn on the way.
   Where the model's ``difference`` is shorter than the deviation (by more than ``WOUND``),
   the descent begins again from its end, ``MOST_TURNS`` times at most.

mhe/compiled/descent.c is the same in C.

References
----------
Nocedal, Wright (2006), Numerical Optimization, sections 3.1 and 10.3.
Walker, Ni (2011), Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49(4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from estimation.status import Status
from mhe.rules import (
    FLOOR,
    GATE,
    RESOLUTION,
    ROUNDING,
    SHORTEST_SETTLING,
    SHORTEST_STEP,
    SINGULAR,
    SUFFICIENT,
)
from mhe.scheme import Scheme
from models.arrays import Array


@dataclass(frozen=True, eq=False)
class LinearisedOptimum:
    """The linearised window's optimum.

    Parameters
    ----------
    g : the point; meets all rows
    length : squared length of the step to it from the current point
    status : whether its rows can be met
    is_changed : whether other rows hold it than held the one before
    """

    g: Array
    length: float
    status: Status = Status.SOLVED
    is_changed: bool = False


class Descending(Protocol):
    """What is descended on: a current point, and a candidate beside it."""

    is_constrained: bool

    def linearise(self) -> LinearisedOptimum:
        """Return the linearised optimum around the current point."""

    def penalty(self) -> float:
        """Return the weighed violation of the rows at the current point."""

    def penalty_tried(self) -> float:
        """Return that of the candidate, in the same weights."""

    def is_late(self) -> bool:
        """Return whether another pass would end too late."""

    def propose(self, z: Array) -> float:
        """Make z the candidate; return its cost."""

    def take(self) -> None:
        """Make the candidate the current point."""

    def inner(self, a: Array, b: Array) -> float:
        """Return the inner product of two steps, in units of the whitened problem."""


@dataclass(frozen=True)
class Descended:
    """How a descent ended: cost of the current point, status, number of passes.

    ``kkt`` is the length of the last step that was judged, in standard deviations.
    """

    cost: float
    status: Status
    iterations: int
    kkt: float = math.nan


def descend(problem: Descending, z: Array, cost: float, scheme: Scheme, made: int = 0) -> Descended:
    """Descend from the current point z with a given cost; see the module.

    Parameters
    ----------
    made : iterations that this window has had already
    """
    J, alpha, base, kkt, last_ratio = cost, 1.0, math.inf, math.nan, 1.0
    points: list[tuple[Array, Array]] = []
    settling = accelerated = False
    iterations = made
    while True:
        iterations += 1
        found = problem.linearise()
        g, length, failed = found.g, found.length, found.status
        if not math.isfinite(length):
            return Descended(J, Status.NOT_FINITE, iterations, kkt)
        limited = iterations >= scheme.max_iterations
        if settling and not length < base:  # the cost cannot tell, the step's length can
            over = _stopped(problem, limited)
            alpha = 1.0 if accelerated else alpha / 2
            accelerated = False
            is_stuck = alpha < SHORTEST_SETTLING
            z, g = points[0]
            if over or is_stuck:
                J = problem.propose(z)
                problem.take()
                failed = over or Status.SOLVER_FAILED
                status = Status.SOLVED if math.sqrt(base) <= FLOOR else failed
                return Descended(J, status, iterations, kkt)
            z = (1 - alpha) * z + alpha * g
            J = problem.propose(z)
        else:
            points = [(z, g)] if found.is_changed else [(z, g), *points[:2]]
            ratio = 1.0 if found.is_changed or base == math.inf else math.sqrt(length / base)
            shrinks, last_ratio = max(ratio, last_ratio), ratio  # the worse of two
            base, alpha = length, 1.0
            kkt = math.sqrt(length)
            is_last = kkt <= scheme.tolerance or shrinks * kkt <= scheme.tolerance
            if scheme.max_iterations == 0 and not is_last:
                return Descended(J, failed | Status.ITERATION_LIMIT, iterations, kkt)
            level = J + problem.penalty()
            settling = math.isfinite(level) and length / 2 < RESOLUTION * max(1.0, abs(level))
            z_try, J_try, accelerated = z, J, False
            if not is_last and kkt < GATE:
                proposal = _accelerated(problem, points)
                if proposal is not None:
                    z_try, J_try = proposal, problem.propose(proposal)
                    tried = J_try + problem.penalty_tried()
                    falls = tried <= level - SUFFICIENT * length
                    accelerated = math.isfinite(tried) if settling else falls
            while not accelerated:
                if alpha < SHORTEST_STEP:
                    return Descended(J, failed | Status.SOLVER_FAILED, iterations, kkt)
                z_try = (1 - alpha) * z + alpha * g
                J_try = problem.propose(z_try)
                tried = J_try + problem.penalty_tried()
                slack = ROUNDING * max(1.0, abs(level))
                falls = tried <= level - SUFFICIENT * alpha * length + slack
                if math.isfinite(tried) and (settling or is_last or falls):
                    break
                if problem.is_constrained and alpha == 1 and math.isfinite(tried) and kkt < GATE:
                    settling = True  # a curved row: its merit would shorten good steps
                    break
                alpha /= 2
            z, J = z_try, J_try
            if is_last:
                problem.take()
                return Descended(J, failed, iterations, kkt)
        problem.take()
        if failed:
            return Descended(J, failed, iterations, kkt)
        if over := _stopped(problem, limited):
            return Descended(J, over, iterations, kkt)


def _stopped(problem: Descending, is_limited: bool) -> Status:
    """Return why there may be no further pass; solved where there may."""
    if is_limited:
        return Status.ITERATION_LIMIT
    return Status.TIME_LIMIT if problem.is_late() else Status.SOLVED


def _accelerated(problem: Descending, points: Sequence[tuple[Array, Array]]) -> Array | None:
    """Return Anderson's proposal from the newest points (z, g), newest first.

    ``g - γ₁ (g - g₁) - γ₂ (g₁ - g₂)`` with the γ that make the step f = g - z shortest to
    first order, ``f - γ₁ (f - f₁) - γ₂ (f₁ - f₂)``. None without an earlier point.
    """
    if len(points) < 2:
        return None
    (z, g), (z_1, g_1) = points[:2]
    f, f_1 = g - z, (g - z) - (g_1 - z_1)
    z_2, g_2 = points[2] if len(points) > 2 else (z_1, g_1)
    f_2 = (g_1 - z_1) - (g_2 - z_2)
    a, b, c = problem.inner(f_1, f_1), problem.inner(f_1, f_2), problem.inner(f_2, f_2)
    left, right = problem.inner(f_1, f), problem.inner(f_2, f)
    determinant = a * c - b * b
    if determinant > SINGULAR * a * c:
        gamma_1 = (c * left - b * right) / determinant
        gamma_2 = (a * right - b * left) / determinant
        return g - gamma_1 * (g - g_1) - gamma_2 * (g_1 - g_2)
    return g - left / a * (g - g_1) if a > 0 else None
