"""The one rotation of the pen, and rotations as vectors.

A pen's attitude is `world_to_body`, and every other rotation of angles is built from
`about_z`; nothing else types a rotation matrix of angles.
"""

from __future__ import annotations

import casadi as ca

SMALL_ANGLE_SQUARED = 1e-12
"""Below this squared sine, `rotation_vector` uses the limit of its formula (rad²)."""


def world_to_body(azimuth: ca.SX, elevation: ca.SX, spin: ca.SX | float) -> ca.SX:
    """Return the matrix that turns world coordinates into body coordinates.

    ``B = Rz(ψ) · [[sinθ, 0, -cosθ], [0, 1, 0], [cosθ, 0, sinθ]] · Rz(φ)`` with
    ``Rz(a) = [[cos a, sin a, 0], [-sin a, cos a, 0], [0, 0, 1]]``. Without
    spin the body axes are x = -e_θ, y = e_φ, z = e_r, where
    ``e_r = (cosθ cosφ, cosθ sinφ, sinθ)`` points from the tip to the top.

    Parameters
    ----------
    azimuth : φ, rad, scalar expression
    elevation : θ, rad, scalar expression; 0 is a pen that lies, π/2 one that stands
    spin : ψ, rad, rotation about the body's z axis, applied last

    Returns
    -------
    (3, 3) expression; its transpose turns body coordinates into world coordinates.

    References
    ----------
    [Pen] equation (7); spin is this project's addition.
    """
    sin, cos = ca.sin(elevation), ca.cos(elevation)
    tilt = ca.vertcat(ca.horzcat(sin, 0, -cos), ca.horzcat(0, 1, 0), ca.horzcat(cos, 0, sin))
    return about_z(spin) @ tilt @ about_z(azimuth)


def about_z(angle: ca.SX | float) -> ca.SX:
    """Return the change of coordinates into a frame turned by `angle` (rad) about z."""
    sin, cos = ca.sin(angle), ca.cos(angle)
    return ca.vertcat(ca.horzcat(cos, sin, 0), ca.horzcat(-sin, cos, 0), ca.horzcat(0, 0, 1))


def vee(skew: ca.SX) -> ca.SX:
    """Return the (3,) vector v of a (3, 3) skew-symmetric matrix [v]×."""
    return ca.vertcat(skew[2, 1], skew[0, 2], skew[1, 0])


def cross_matrix(vector: ca.SX) -> ca.SX:
    """Return [v]×, the (3, 3) matrix with ``[v]× u = v × u``."""
    x, y, z = vector[0], vector[1], vector[2]
    return ca.vertcat(ca.horzcat(0, -z, y), ca.horzcat(z, 0, -x), ca.horzcat(-y, x, 0))


def _angle_over_sine(sine_squared: ca.SX, cosine: ca.SX) -> ca.SX:
    """Return θ / sinθ, 1 at θ = 0, with finite derivatives everywhere.

    Both branches of a symbolic condition are evaluated, so the one that is not
    taken must be finite too.
    """
    is_small = sine_squared < SMALL_ANGLE_SQUARED
    sine = ca.sqrt(ca.if_else(is_small, 1.0, sine_squared))
    return ca.if_else(is_small, 1 + sine_squared / 6, ca.atan2(sine, cosine) / sine)


def rotation_vector(matrix: ca.SX) -> ca.SX:
    """Return the (3,) rotation vector (rad) of a (3, 3) rotation matrix, Log(R).

    Valid for angles up to π. Within 1e-6 rad of π, where the skew part vanishes,
    it is half a turn about the axis of the symmetric part, of either sign.
    """
    sine_axis = vee(matrix - matrix.T) / 2
    cosine = (ca.trace(matrix) - 1) / 2
    sine_squared = ca.sumsqr(sine_axis)
    is_half_turn = ca.logic_and(sine_squared < SMALL_ANGLE_SQUARED, cosine < 0)
    return ca.if_else(
        is_half_turn,
        ca.pi * _half_turn_axis(matrix),
        sine_axis * _angle_over_sine(sine_squared, cosine),
    )


def _half_turn_axis(matrix: ca.SX) -> ca.SX:
    """Return the unit axis a of R = 2 a aᵀ - I: the longest column of R + I."""
    columns, x, y, z = matrix + ca.SX.eye(3), matrix[0, 0], matrix[1, 1], matrix[2, 2]
    longest = ca.if_else(
        ca.logic_and(x >= y, x >= z),
        columns[:, 0],
        ca.if_else(y >= z, columns[:, 1], columns[:, 2]),
    )
    return longest / ca.norm_2(longest)


def rotation_matrix(vector: ca.SX) -> ca.SX:
    """Return the (3, 3) rotation matrix of a (3,) rotation vector (rad), Exp(v)."""
    squared = ca.sumsqr(vector)
    is_small = squared < SMALL_ANGLE_SQUARED
    angle = ca.sqrt(ca.if_else(is_small, 1.0, squared))
    sine_term = ca.if_else(is_small, 1 - squared / 6, ca.sin(angle) / angle)
    cosine_term = ca.if_else(is_small, 0.5 - squared / 24, (1 - ca.cos(angle)) / angle**2)
    skew = cross_matrix(vector)
    return ca.SX.eye(3) + sine_term * skew + cosine_term * (skew @ skew)


def axis_difference(direction: ca.SX) -> ca.SX:
    """Return the (2,) rotation about body x and y (rad) that takes z to a direction.

    Parameters
    ----------
    direction : (3,) unit vector in body coordinates
    """
    x, y, z = direction[0], direction[1], direction[2]
    return ca.vertcat(-y, x) * _angle_over_sine(x**2 + y**2, z)
