"""A pen's state as a rigid body, whatever its coordinates are."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np

from models import attitude
from models.arrays import Array
from models.euler_pen import euler_body
from models.free_pen import N_FREE, SIGMA, FreeBody
from models.kinematics import Body
from models.pen_config import PenConfig


def pen_body(x: ca.SX, degrees_of_freedom: int, *, fixed_spin_rad: float = 0.0) -> Body:
    """Return the body of a pen in symbols of its state (n_x,), biases last.

    Parameters
    ----------
    degrees_of_freedom, fixed_spin_rad : see `models.pen_config.PenConfig`
    """
    if degrees_of_freedom == 6:
        return FreeBody(x[:N_FREE])
    n = degrees_of_freedom
    return euler_body(x[:n], x[n : 2 * n], x[2 * n : 3 * n], fixed_spin_rad=fixed_spin_rad)


def rates_and_attitudes(pen: PenConfig, states: Array) -> tuple[Array, Array]:
    """Return body rates and attitudes of a pen's states (n, n_x).

    Returns
    -------
    (n, 3) rad/s, and (n, 3, 3) world-to-body rotations B
    """
    n = len(states)
    if not n:
        return np.zeros((0, 3)), np.zeros((0, 3, 3))
    function = _rates_and_attitudes(states.shape[1], pen.degrees_of_freedom, pen.fixed_spin_rad)
    # One call for all instants: CasADi takes a column for each.
    rates, turned = function(states.T)
    return rates.full().T, turned.full().T.reshape(n, 3, 3)


def headings(states: Array) -> Array:
    """Return the headings N (n, 3, 3) of a free pen's states (n, n_x): what turns a tangent
    vector of the attitude into a turn in the world; see `models.attitude.heading`.
    """
    rows = _heading()(states[:, SIGMA].T)
    return np.asarray(rows.full().T.reshape(len(states), 3, 3))


@cache
def _heading() -> ca.Function:
    """Return (σ (3,)) -> the rows of N one after another (9,)."""
    sigma = ca.SX.sym("sigma", 3)
    return ca.Function("heading", [sigma], [ca.densify(ca.vec(attitude.heading(sigma).T))])


@cache
def _rates_and_attitudes(n_x: int, degrees_of_freedom: int, fixed_spin_rad: float) -> ca.Function:
    """Return (x (n_x,)) -> ω (3,), the rows of B one after another (9,)."""
    x = ca.SX.sym("x", n_x)
    body = pen_body(x, degrees_of_freedom, fixed_spin_rad=fixed_spin_rad)
    rows = ca.vec(body.world_to_body.T)
    return ca.Function("body", [x], [ca.densify(body.body_rate()), ca.densify(rows)])
