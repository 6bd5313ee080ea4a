"""Steps of a state: plain sums where its tangent space is that of its coordinates.

Of a window's angles, which run on without a wrap, `model.retract` and `model.difference` would
cost a contender a wrap that no one needs. An attitude has no sums.
"""

from __future__ import annotations

import casadi as ca

from models.state_space import StateSpaceModel


def is_plain(model: StateSpaceModel) -> bool:
    """Whether states may be added and subtracted as vectors."""
    return model.tangent is None


def moved(model: StateSpaceModel, x: ca.SX, d: ca.SX) -> ca.SX:
    """Return the state (n_x,) that is a tangent vector d (n_x,) away from x."""
    return x + d if is_plain(model) else model.retract(x, d)


def away(model: StateSpaceModel, to: ca.SX, of: ca.SX) -> ca.SX:
    """Return the tangent vector (n_x,) from one state to another."""
    return to - of if is_plain(model) else model.difference(to, of)


def along(expression: ca.SX, d: ca.SX) -> ca.SX:
    """Return the derivative of an expression of a step d (n,), at no step."""
    return ca.substitute(ca.jacobian(expression, d), d, ca.SX.zeros(d.numel()))
