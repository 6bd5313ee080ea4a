"""Noises that states carry: bounds on process noise, and slacks of soft constraints.

    s_{k+1} = w_k where Δt > 0, else s_k;     s_0 ~ N(0, 1)

A bound on w_k is one on the state s_{k+1}. A soft constraint asks for g(x_k) ≤ σ s_k with a noise
that does nothing else: the cheapest one makes it cost ½ (max(0, g(x_k)) / σ)². Both are exact, and
no solver needs to know of more than bounds and inequalities of states. A Kalman filter obeys
neither, so these states tell it nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.own_bounds import Bound, own_bounds
from models.own_noise import SIGMA

SoftConstraint = tuple[Callable[[ca.SX], ca.SX], float]
"""(x (n_x,)) → g, that should be ≤ 0, and the deviation σ that costs as much as one of a noise."""


@dataclass(frozen=True, eq=False)
class Carried:
    """States behind a model's own.

    Parameters
    ----------
    names : (n_c,)
    noises : (n_c,) which noise each of them carries
    n_noises : of the model's own; noises of soft constraints stand behind them
    lower, upper : (n_c,) bounds
    soft : constraints of the last states
    """

    names: tuple[str, ...]
    noises: tuple[int, ...]
    n_noises: int
    lower: Array
    upper: Array
    soft: tuple[SoftConstraint, ...]

    @property
    def units(self) -> tuple[str, ...]:
        """(n_c,): all in standard deviations."""
        return (SIGMA,) * len(self.names)

    @property
    def n_w(self) -> int:
        """Number of all noises."""
        return self.n_noises + len(self.soft)

    def after_step(self, before: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
        """Return the states (n_c,) behind a step, of those before it and its noises (n_w,)."""
        pairs = zip(self.noises, ca.vertsplit(before), strict=True) if self.names else ()
        return ca.vertcat(ca.SX(0, 1), *(ca.if_else(dt > 0, w[i], s) for i, s in pairs))

    def inequality(self, x: ca.SX) -> ca.SX:
        """Return rows (n_soft,) that have to be ≤ 0, of the states with these behind them."""
        own = x[: x.numel() - len(self.names)]
        slacks = ca.vertsplit(x)[x.numel() - len(self.soft) :]
        pairs = zip(self.soft, slacks, strict=True)
        return ca.vertcat(ca.SX(0, 1), *(g(own) - std * s for (g, std), s in pairs))


def carried_noises(
    model: str,
    n_noises: int,
    bounds: Mapping[int, Bound],
    soft: Mapping[str, SoftConstraint],
    *,
    taken: Collection[str],
    n_x: int,
) -> Carried:
    """Return the states that carry a model's bounded noises and its constraints' slacks.

    Parameters
    ----------
    model : its name
    bounds : number of a noise → (lower, upper)
    soft : name of the slack's state → constraint
    taken : names of its other quantities
    n_x : number of its own states

    Raises
    ------
    InputError
        If there is no such noise, a bound is empty, a name is taken, or a constraint is not one
        expression with a positive deviation.
    """
    for i in bounds:
        if i not in range(n_noises):
            raise InputError(
                f"model {model}: bound on noise {i!r}, expected a number from 0 to {n_noises - 1}"
            )
    of_noises = {f"noise_{i}": bound for i, bound in bounds.items()}
    names = (*of_noises, *soft)
    for name in names:
        if not isinstance(name, str) or name in taken or names.count(name) > 1:
            raise InputError(
                f"model {model}: {name!r} is the name of another quantity, or no text, "
                "expected a name of its own for the state of a bounded noise or soft constraint"
            )
    for name, constraint in soft.items():
        _check_soft(f"model {model}: soft constraint {name}", constraint, n_x)
    lower, upper = own_bounds(model, names, of_noises)
    noises = (*bounds, *range(n_noises, n_noises + len(soft)))
    return Carried(names, noises, n_noises, lower, upper, tuple(soft.values()))


def _check_soft(what: str, constraint: SoftConstraint, n_x: int) -> None:
    try:
        g, std = constraint
        is_good = callable(g) and 0 < std < np.inf
    except (TypeError, ValueError):
        is_good = False
    if not is_good:
        raise InputError(
            f"{what} is {constraint!r}, expected (function of the states, positive deviation)"
        )
    shape = ca.SX(g(ca.SX.sym("x", n_x))).shape
    if shape != (1, 1):
        raise InputError(f"{what} has shape {shape}, expected one expression that should be ≤ 0")
