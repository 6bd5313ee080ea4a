"""Terms of a window's objective, and the Hessian that their residuals make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from mhe.loss import LEAST_SQUARES, huber, huber_weight


@dataclass(frozen=True, eq=False)
class Term:
    """One term of the objective: residual (n,), its weight ω in a Hessian, its cost ρ."""

    residual: ca.SX
    weight: ca.SX
    cost: ca.SX


def squares(residual: ca.SX) -> Term:
    """Return half the sum of squares."""
    return Term(residual, ca.SX.ones(residual.numel()), ca.sumsqr(residual) / 2)


def term(residual: ca.SX, threshold: float) -> Term:
    """Return Huber's loss of a residual's length; half its square where there is no threshold."""
    if threshold >= LEAST_SQUARES:
        return squares(residual)
    squared = ca.sumsqr(residual)
    weight = huber_weight(squared, ca.SX(threshold))
    return Term(residual, ca.repmat(weight, residual.numel(), 1), huber(squared, ca.SX(threshold)))


def gauss_newton(nlp: dict[str, ca.SX], terms: Sequence[Term]) -> ca.Function:
    """Return the upper triangle of JᵀΩJ as a Hessian of the Lagrangian.

    It leaves out the curvature of residuals, losses and constraints.
    """
    factor, multipliers = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", nlp["g"].numel())
    residual = ca.vertcat(*(term.residual for term in terms))
    weight = ca.vertcat(*(term.weight for term in terms))
    J = ca.jacobian(residual, nlp["x"])
    return ca.Function(
        "gauss_newton",
        [nlp["x"], nlp["p"], factor, multipliers],
        [ca.triu(factor * (J.T @ ca.diag(weight) @ J))],
        ["x", "p", "lam_f", "lam_g"],
        ["triu_hess_gamma_x_x"],
        {"cse": True},
    )
