"""Attitudes as modified Rodrigues parameters: three numbers without a singularity.

σ stands for the unit quaternion q(σ) = (1 - σ·σ, 2σ) / (1 + σ·σ), body to world; q and -q are
the same attitude, and the one with |σ| ≤ 1 is kept (the other is its shadow), so

    σ₁ ⊗ σ₂ = ((1 - s₁) σ₂ + (1 - s₂) σ₁ + 2 σ₁ × σ₂) / (1 + s₁ s₂ - 2 σ₁·σ₂),   s = σ·σ
    R(σ) = I + (4 (1 - s) [σ]× + 8 [σ]×²) / (1 + s)²

Small turns: Exp(δ) turns by a rotation vector; a tangent vector d is the attitude d/4, which is
the same to second order, and rational.

References
----------
Schaub, Junkins (1996), Stereographic orientation parameters for attitude dynamics, J.
Astronautical Sciences 44(1).
"""

from __future__ import annotations

import casadi as ca

from models.rotation import cross_matrix

SMALL_TURN_SQUARED = 1e-4
"""Squared rotation vector below which tan(θ/4)/θ is its power series, rad²."""

UPRIGHT_SHIFT = 1e-16
"""Added to a component of the axis, so that angles of a pen that stands exactly upright have
derivatives: huge ones of azimuth and spin, of length 1 of elevation."""

HALF_SWING = 1e-28
"""Of q_w² + q_z², below which a swing is half a turn, to rounding."""
LEAST_TWIST = 0.01
"""Of q_w² + q_z² = (1 + R_zz) / 2, down to which a heading is told by q_w and q_z: 11° from where
the body's z axis points straight down."""


def body_to_world(sigma: ca.SX) -> ca.SX:
    """Return R (3, 3), which turns body coordinates into world coordinates."""
    s, skew = ca.sumsqr(sigma), cross_matrix(sigma)
    return ca.SX.eye(3) + (4 * (1 - s) * skew + 8 * (skew @ skew)) / (1 + s) ** 2


def product(first: ca.SX, second: ca.SX) -> ca.SX:
    """Return σ₁ ⊗ σ₂, the attitude R(σ₁) R(σ₂), with |σ| ≤ 1."""
    s1, s2, dot = ca.sumsqr(first), ca.sumsqr(second), ca.dot(first, second)
    turned = (1 - s1) * second + (1 - s2) * first + 2 * ca.cross(first, second)
    is_shadow = (1 - s1) * (1 - s2) - 4 * dot < 0
    return turned / ca.if_else(is_shadow, -(s1 + s2 + 2 * dot), 1 + s1 * s2 - 2 * dot)


def exponential(turn: ca.SX) -> ca.SX:
    """Return σ of a rotation vector (rad): tan(θ/4) along its axis."""
    squared = ca.sumsqr(turn)
    is_small = squared < SMALL_TURN_SQUARED
    angle = ca.sqrt(ca.if_else(is_small, 1.0, squared))
    series = 1 / 4 + squared * (1 / 192 + squared * (1 / 7680))
    return turn * ca.if_else(is_small, series, ca.tan(angle / 4) / angle)


def turn(N: ca.SX, d: ca.SX) -> ca.SX:
    """Return the turn in the world (an attitude) of a tangent vector (rad) in a frame N (3, 3).

    W = Exp(d₃ e_z) Exp(N (d₁, d₂, 0)): first a tilt about a level axis, then a turn about the
    vertical. In a frame that goes with the `heading` whatever is known of a tilt relative to the
    body stays so when the heading moves, however far; in `fixed` axes what is known relative to
    the world, a field, does.
    """
    level = N @ ca.vertcat(d[0], d[1], 0)
    return product(exponential(ca.vertcat(0, 0, d[2])), level / 4)


def tangent(N: ca.SX, turn: ca.SX) -> ca.SX:
    """Return the tangent vector, in a frame, of a turn: its swing and twist about the vertical."""
    w, x, y, z = ca.vertsplit(quaternion(turn))
    is_half = w**2 + z**2 < HALF_SWING  # of half a turn any twist is as good: none
    cosine = ca.sqrt(ca.if_else(is_half, 1.0, w**2 + z**2))
    c, s = ca.if_else(is_half, 1.0, w / cosine), ca.if_else(is_half, 0.0, z / cosine)
    level = 4 / (1 + ca.if_else(is_half, 0.0, cosine)) * ca.vertcat(c * x + s * y, c * y - s * x, 0)
    return N.T @ level + ca.vertcat(0, 0, 2 * ca.atan2(s, c))


def retract(sigma: ca.SX, d: ca.SX) -> ca.SX:
    """Return the attitude that a tangent vector, in the heading's frame, is away."""
    return product(turn(heading(sigma), d), sigma)


def difference(to: ca.SX, of: ca.SX) -> ca.SX:
    """Return the tangent vector from one attitude to another."""
    return tangent(heading(of), product(to, -of))


def quaternion(sigma: ca.SX) -> ca.SX:
    """Return (w, x, y, z) (4,), body to world, w ≥ 0."""
    s = ca.sumsqr(sigma)
    return ca.vertcat(1 - s, 2 * sigma) / (1 + s)


def heading(sigma: ca.SX) -> ca.SX:
    """Return N (3, 3), the turn about the vertical in R = N M, where M's axis is level.

    The twist of a swing-twist decomposition: tan(ψ/2) = q_z / q_w. It has no value where the body's
    z axis points straight down; near there R is taken with the body turned half about its x.
    """
    w, x, y, z = ca.vertsplit(quaternion(sigma))
    is_plain = w**2 + z**2 > LEAST_TWIST
    a, b = ca.if_else(is_plain, w, x), ca.if_else(is_plain, z, y)
    size = a**2 + b**2
    cos, sin = (a**2 - b**2) / size, 2 * a * b / size
    return ca.vertcat(ca.horzcat(cos, -sin, 0), ca.horzcat(sin, cos, 0), ca.horzcat(0, 0, 1))


def fixed(_: ca.SX) -> ca.SX:
    """Return the world's own axes (3, 3), whatever the attitude: a frame as `heading` is one."""
    return ca.SX.eye(3)


def level_part(sigma: ca.SX) -> ca.SX:
    """Return cosθ ≥ 0, the length of a pen's axis seen from above: 0 where it stands upright."""
    return _level(body_to_world(sigma)[:2, 2])


def _level(axis: ca.SX) -> ca.SX:
    return ca.sqrt(ca.sumsqr(axis + ca.DM([UPRIGHT_SHIFT, 0])))


def pen_angles(sigma: ca.SX) -> ca.SX:
    """Return azimuth, elevation and spin (3,), rad, of a pen; see `models.rotation.world_to_body`.

    Upright, azimuth and spin are not told apart.
    """
    R = body_to_world(sigma)
    axis = R[:, 2]  # (cosθ cosφ, cosθ sinφ, sinθ)
    # The last row of R is that of B's last column: (-cosθ cosψ, cosθ sinψ, sinθ).
    return ca.vertcat(
        ca.atan2(axis[1], axis[0] + UPRIGHT_SHIFT),
        ca.atan2(axis[2], _level(axis[:2])),
        ca.atan2(R[2, 1], UPRIGHT_SHIFT - R[2, 0]),
    )


def from_matrix(R: ca.SX) -> ca.SX:
    """Return σ of a rotation matrix, body to world, |σ| ≤ 1; exact for every attitude.

    By the largest of the four components of its quaternion.
    """
    xx, yy, zz = R[0, 0], R[1, 1], R[2, 2]
    squares = (1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz)
    rows = (
        (squares[0], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]),
        (R[2, 1] - R[1, 2], squares[1], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]),
        (R[0, 2] - R[2, 0], R[0, 1] + R[1, 0], squares[2], R[1, 2] + R[2, 1]),
        (R[1, 0] - R[0, 1], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], squares[3]),
    )
    q, largest = ca.vertcat(*rows[0]), squares[0]
    for row, square in zip(rows[1:], squares[1:], strict=True):
        q = ca.if_else(square > largest, ca.vertcat(*row), q)
        largest = ca.fmax(largest, square)
    q = q / ca.norm_2(q)
    q = ca.if_else(q[0] < 0, -q, q)
    return q[1:] / (1 + q[0])
