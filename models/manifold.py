"""Parts of a model that many models share: plain coordinates with wrapped angles, no constraint."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

TURN = 2 * ca.pi


def additive_manifold(wrapped: Sequence[bool]) -> tuple[ca.Function, ca.Function]:
    """Return (retract, difference) of plain addition with wrapped angles.

    Parameters
    ----------
    wrapped : (n_x,), true where a component is an angle on the circle: it is
        then kept within (-π, π], and the difference is the short way round
    """
    x, delta = ca.SX.sym("x", len(wrapped)), ca.SX.sym("delta", len(wrapped))

    def wrap(vector: ca.SX) -> ca.SX:
        return wrapped_angles(vector, wrapped)

    retract = ca.Function("retract", [x, delta], [wrap(x + delta)], ["x", "delta"], ["x_moved"])
    other = ca.SX.sym("other", len(wrapped))
    difference = ca.Function("difference", [x, other], [wrap(x - other)], ["to", "from"], ["delta"])
    return retract, difference


def wrapped_angles(vector: ca.SX, wrapped: Sequence[bool]) -> ca.SX:
    """Return a vector (n,) with the components that are angles on the circle within (-π, π]."""
    return ca.vertcat(
        *(_principal(vector[i]) if angle else vector[i] for i, angle in enumerate(wrapped))
    )


def _principal(angle: ca.SX) -> ca.SX:
    """Return an angle less its whole turns; C's `remainder` takes several times as long."""
    return angle - TURN * ca.ceil(angle * (1 / TURN) - 0.5)


def no_inequality(n_x: int) -> ca.Function:
    """Return the inequality of a model that has none: (n_x,) -> (0,)."""
    x = ca.SX.sym("x", n_x)
    return ca.Function("inequality", [x], [ca.SX(0, 1)], ["x"], ["g"])


def always_regular(n_x: int) -> ca.Function:
    """Return the regularity of a model without singular coordinates: the constant 1."""
    x = ca.SX.sym("x", n_x)
    return ca.Function("regularity", [x], [ca.SX(1)], ["x"], ["margin"])
