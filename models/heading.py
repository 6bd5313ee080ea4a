"""The heading of a pen, a symmetry: nothing but a camera knows where north is.

Turn tip, velocity and acceleration about a vertical axis and the azimuth with
them: gravity, body rates and specific forces stay as they are, and so does the
distance to a point of that axis.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from models.arrays import Array
from models.rotation import about_z


def heading_symmetry(n_q: int, n_x: int, *, centre_m: Array | None = None) -> ca.Function:
    """Return (x (n_x,), angle, rad) -> the same pen seen from another side.

    Parameters
    ----------
    n_q : degrees of freedom (X, Y, Z, φ, θ[, ψ]) of x = (q, q̇, q̈, biases)
    centre_m : (3,) a point on the vertical axis; the origin by default
    """
    x, angle = ca.SX.sym("x", n_x), ca.SX.sym("angle")
    centre = ca.DM(np.zeros(3) if centre_m is None else centre_m)
    # about_z changes coordinates; its transpose turns the vector itself.
    turn = about_z(angle).T
    turned = ca.SX(x)
    turned[:3] = centre + turn @ (x[:3] - centre)
    turned[3] = x[3] + angle
    for block in (1, 2):
        rows = slice(block * n_q, block * n_q + 3)
        turned[rows] = turn @ x[rows]
    return ca.Function("heading", [x, angle], [ca.densify(turned)], ["x", "angle"], ["x_turned"])
