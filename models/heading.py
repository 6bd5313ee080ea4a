"""The heading of a pen, a symmetry: nothing but a camera knows where north is.

Turn tip, velocity and acceleration about a vertical axis and the attitude with
them: gravity, body rates and specific forces stay as they are, and so does the
distance to a point of that axis. Vertical is against gravity, whatever the world's z is.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from models import attitude
from models.arrays import Array
from models.free_pen import SIGMA, TIP, A, V
from models.level import UP, Vector3
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

    # about_z changes coordinates; its transpose turns the vector itself.
    return _symmetry(turn_azimuth, lambda angle: about_z(angle).T, vectors, n_x, centre_m)


def free_heading_symmetry(
    n_x: int, *, centre_m: Array | None = None, up: Vector3 = UP
) -> ca.Function:
    """Return the same for a pen that turns freely, see `models.free_pen`.

    Parameters
    ----------
    up : unit vector against gravity, see `models.level`
    """

    def about_vertical(angle: ca.SX) -> ca.SX:
        return attitude.exponential(angle * ca.DM(up))

    def turn_attitude(turned: ca.SX, angle: ca.SX) -> None:
        turned[SIGMA] = attitude.product(about_vertical(angle), turned[SIGMA])

    def turn(angle: ca.SX) -> ca.SX:
        return about_z(angle).T if up == UP else attitude.body_to_world(about_vertical(angle))

    return _symmetry(turn_attitude, turn, (V, A), n_x, centre_m)


def _symmetry(
    turn_attitude: Callable[[ca.SX, ca.SX], None],
    matrix: Callable[[ca.SX], ca.SX],
    vectors: tuple[slice, slice],
    n_x: int,
    centre_m: Array | None,
) -> ca.Function:
    """Return the symmetry of a state whose first three numbers are the tip.

    Parameters
    ----------
    turn_attitude : turns that part of a state in place
    matrix : angle -> (3, 3), what turns a vector in the world
    vectors : the parts that are vectors in the world
    """
    x, angle = ca.SX.sym("x", n_x), ca.SX.sym("angle")
    centre = ca.DM(np.zeros(3) if centre_m is None else centre_m)
    turn = matrix(angle)
    turned = ca.SX(x)
    turned[TIP] = centre + turn @ (x[TIP] - centre)
    turn_attitude(turned, angle)
    for part in vectors:
        turned[part] = turn @ x[part]
    return ca.Function("heading", [x, angle], [ca.densify(turned)], ["x", "angle"], ["x_turned"])
