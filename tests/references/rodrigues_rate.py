"""How fast modified Rodrigues parameters change: σ̇ = ¼ ((1 - s) ω + 2 σ × ω + 2 σ (σ·ω)).

Schaub, Junkins (1996), Stereographic orientation parameters for attitude dynamics, J.
Astronautical Sciences 44(1), with ω in the body and s = σ·σ.
"""

from __future__ import annotations

import casadi as ca


def rate(sigma: ca.SX, body_rate: ca.SX) -> ca.SX:
    """σ̇ of a body rate (rad/s)."""
    s = ca.sumsqr(sigma)
    turned = (1 - s) * body_rate + 2 * ca.cross(sigma, body_rate)
    return (turned + 2 * sigma * ca.dot(sigma, body_rate)) / 4
