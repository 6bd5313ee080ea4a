"""What people read of a state, where its coordinates are not that.

A pen that turns freely has an attitude of three numbers that no one can read; its azimuth,
elevation and spin are outputs, with standard deviations through the Jacobian along the tangent
space. A model without outputs is read by its states.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from models.manifold import wrapped_angles

UNIFORM_ANGLE_STD_RAD = math.pi / math.sqrt(3)
"""Standard deviation of an angle of which nothing is known."""


@dataclass(frozen=True, eq=False)
class Outputs:
    """Quantities that people read.

    Parameters
    ----------
    names, units : (n_o,); a state under its own name is that state
    function : casadi.Function (n_x,) -> (n_o,)
    wrapped : (n_o,) true where a quantity is an angle on the circle
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    function: ca.Function
    wrapped: tuple[bool, ...]

    def jacobian(self, retract: ca.Function, x: ca.SX) -> ca.SX:
        """Return ∂/∂δ function(retract(x, δ)) at δ = 0 (n_o, n_x)."""
        d = ca.SX.sym("d", x.numel())
        J = ca.jacobian(self.function(retract(x, d)), d)
        return ca.substitute(J, d, ca.SX.zeros(x.numel()))

    def bound(self, name: str, low: float, high: float) -> Callable[[ca.SX], ca.SX]:
        """Return the inequality (x) -> rows ≤ 0 that keeps an output within low and high.

        An angle on the circle that has both is kept within half their distance of their middle,
        the short way round.
        """
        index = self.names.index(name)
        is_arc = self.wrapped[index] and math.isfinite(low) and math.isfinite(high)

        def rows(x: ca.SX) -> ca.SX:
            value = self.function(x)[index]
            if is_arc:
                middle, half = (low + high) / 2, (high - low) / 2
                away = wrapped_angles(ca.vertcat(value - middle), (True,))
                return ca.vertcat(away - half, -away - half)
            sides = [value - high] if math.isfinite(high) else []
            sides += [low - value] if math.isfinite(low) else []
            return ca.vertcat(*sides)

        return rows


@dataclass(frozen=True, eq=False)
class TangentNames:
    """A tangent vector in words of motions: "turning about the vertical".

    Parameters
    ----------
    names, units : (n_x,)
    function : casadi.Function (n_x,) -> (n_x, n_x): the regular matrix that turns a tangent vector
        at x into amounts of what `names` names
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    function: ca.Function
