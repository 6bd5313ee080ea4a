"""Steps of a differential equation that solve equations: implicit Runge-Kutta, and CVODES."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np

from models.arrays import Array

STAGES = 3
"""Of Radau IIA: order 2 · 3 - 1 = 5, stiffly accurate."""
NEWTON_TOLERANCE = 1e-12
MAX_NEWTON_STEPS = 30
SOLVED_BELOW = 1e-8
"""Residual of a stage, relative to 1 + its first rate, up to which it counts as solved."""
CVODES_TOLERANCES = {"reltol": 1e-10, "abstol": 1e-12}


@cache
def radau(stages: int = STAGES) -> Array:
    """Return the coefficients A (s, s) of Radau IIA; its last row are the weights.

    Each row integrates polynomials exactly: Σ_j a_ij c_j^q = c_i^(q + 1) / (q + 1), q < s.
    """
    c, q = np.array(ca.collocation_points(stages, "radau")), np.arange(stages)
    integrals = c[:, None] ** (q + 1) / (q + 1)
    return np.asarray(np.linalg.solve((c[:, None] ** q).T, integrals.T).T, dtype=float)


def collocation_step(rates: ca.SX, x: ca.SX, held: ca.SX, h: ca.SX) -> ca.Function:
    """Return (x, held, h) → x after h seconds by Radau IIA, NaN where Newton's method fails.

    Parameters
    ----------
    rates : d/dt x (n_x,) in the symbols x and held
    """
    n_x, A = x.numel(), ca.DM(radau())
    rate = ca.Function("rate", [x, held], [rates])
    slopes = ca.SX.sym("slopes", n_x, STAGES)
    first = rate(x, held)
    moved = [rate(x + h * (slopes @ A[i, :].T), held) for i in range(STAGES)]
    off = (slopes - ca.horzcat(*moved)) / (1 + ca.fabs(ca.repmat(first, 1, STAGES)))
    symbols = ca.vec(slopes), ca.vertcat(x, held, h)
    options = {
        "abstol": NEWTON_TOLERANCE,
        "max_iter": MAX_NEWTON_STEPS,
        "error_on_fail": False,
    }
    equations = {"x": symbols[0], "p": symbols[1], "g": ca.vec(off)}
    solve = ca.rootfinder("stages", "fast_newton", equations, options)
    found = solve(ca.repmat(first, STAGES, 1), symbols[1])
    rest = ca.Function("rest", list(symbols), [ca.norm_inf(ca.vec(off))])(found, symbols[1])
    solved = ca.if_else(rest <= SOLVED_BELOW, 1.0, np.nan)
    after = x + h * (ca.reshape(found, n_x, STAGES) @ A[STAGES - 1, :].T)
    return ca.Function("step", [x, held, h], [solved * after])


def cvodes_step(rates: ca.SX, x: ca.SX, held: ca.SX, h: ca.SX) -> ca.Function:
    """Return (x, held, h) → x after h seconds by CVODES; parameters as of `collocation_step`.

    The time runs from 0 to 1, in which h is a factor.
    """
    equation = {"x": x, "p": ca.vertcat(held, h), "ode": h * rates}
    options = {**CVODES_TOLERANCES, "show_eval_warnings": False}
    integrator = ca.integrator("cvodes", "cvodes", equation, 0.0, 1.0, options)
    after = integrator(x0=x, p=ca.vertcat(held, h))["xf"]
    return ca.Function("step", [x, held, h], [after])
