"""The true states of a pen along a motion, under the name of every state and output there is."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import casadi as ca
import numpy as np

from models import attitude
from models.arrays import Array
from models.euler_pen import euler_body, kinematic_states
from models.free_kinematics import QUATERNION
from models.free_pen import ALPHA, OMEGA, SIGMA, STATES
from models.motions import SampledMotion

TRUE_NAMES = (
    *(name for name, _ in kinematic_states(6)),
    *(name for name, _ in STATES if name not in dict(kinematic_states(6))),
    *QUATERNION,
)
"""Every name of a path."""


@cache
def _of_coordinates() -> ca.Function:
    """(q, q̇, q̈), each (6,) → (σ, q_σ, ω, α)."""
    q, q_dot, q_ddot = (ca.SX.sym(symbol, 6) for symbol in ("q", "q_dot", "q_ddot"))
    body = euler_body(q, q_dot, q_ddot)
    sigma = attitude.from_matrix(body.world_to_body.T)
    rate = body.body_rate()
    values = [sigma, attitude.quaternion(sigma), rate, body.time_derivative(rate)]
    return ca.Function("true_path", [q, q_dot, q_ddot], values)


def true_path(motion: SampledMotion) -> Mapping[str, Array]:
    """Return name → (n,): coordinates with rates, and the attitude with the body's rates."""
    along = [motion.q, motion.q_dot, motion.q_ddot]
    names = [name for name, _ in kinematic_states(6)]
    path = dict(zip(names, np.hstack(along).T, strict=True))
    values = _of_coordinates()(*(part.T for part in along))
    free = [name for name, _ in STATES]
    of_attitude = (free[SIGMA], QUATERNION, free[OMEGA], free[ALPHA])
    for group, rows in zip(of_attitude, values, strict=True):
        path |= dict(zip(group, rows.full(), strict=True))
    return path
