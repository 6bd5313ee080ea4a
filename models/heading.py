"""The heading of a pen, a symmetry: nothing but a camera knows where north is.

Turn tip, velocity and acceleration about a vertical axis and the attitude with
them: gravity, body rates and specific forces stay as they are, and so does the
distance to a point of that axis.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from models import attitude
from models.arrays import Array
from models.free_pen import SIGMA, TIP, A, V
from models.rotation import about_z


def heading_symmetry(n_q: int, n_x: int, *, centre_m: Array | None = None) -> ca.Function:
    """Return (x (n_x,), angle, rad) -> the same pen seen from another side.

    Parameters
    ----------
    n_q : degrees of freedom (X, Y, Z, φ, θ[, ψ]) of x = (q, q̇, q̈, biases)
    centre_m : (3,) a point on the vertical axis; the origin by default
    """
    vectors = slice(n_q, n_q + 3), slice(2 * n_q, 2 * n_q + 3)

    def turn_azimuth(turned: ca.SX, angle: ca.SX) -> None:
        turned[3] += angle

    return _symmetry(turn_azimuth, vectors, n_x, centre_m)


def free_heading_symmetry(n_x: int, *, centre_m: Array | None = None) -> ca.Function:
    """Return the same for a pen that turns freely, see `models.free_pen`."""

    def turn_attitude(turned: ca.SX, angle: ca.SX) -> None:
        about_vertical = attitude.exponential(ca.vertcat(0, 0, angle))
        turned[SIGMA] = attitude.product(about_vertical, turned[SIGMA])

    return _symmetry(turn_attitude, (V, A), n_x, centre_m)


def _symmetry(
    turn_attitude: Callable[[ca.SX, ca.SX], None],
    vectors: tuple[slice, slice],
    n_x: int,
    centre_m: Array | None,
) -> ca.Function:
    """Return the symmetry of a state whose first three numbers are the tip.

    Parameters
    ----------
    turn_attitude : turns that part of a state in place
    vectors : the parts that are vectors in the world
    """
    x, angle = ca.SX.sym("x", n_x), ca.SX.sym("angle")
    centre = ca.DM(np.zeros(3) if centre_m is None else centre_m)
    # about_z changes coordinates; its transpose turns the vector itself.
    turn = about_z(angle).T
    turned = ca.SX(x)
    turned[TIP] = centre + turn @ (x[TIP] - centre)
    turn_attitude(turned, angle)
    for part in vectors:
        turned[part] = turn @ x[part]
    return ca.Function("heading", [x, angle], [ca.densify(turned)], ["x", "angle"], ["x_turned"])
