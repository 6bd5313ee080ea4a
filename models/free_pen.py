"""A pen that turns freely: attitude without a singularity, and rates of its body.

    x = (p, σ, v, ω, a, α, biases)

p is the tip, σ the attitude (`models.attitude`), v and a the tip's velocity and acceleration in
the world, ω and α the body's rate and its derivative in body axes. Tip and attitude are moved by
chains (`models.chains`), isotropic, so that no direction is told from another:

    (p, v, a)⁺ = (F_p ⊗ I) (p, v, a) + (G_p ⊗ N) w,   N the heading
    R⁺ = R Exp(F_α,12 ω + F_α,13 α + first row of (G_α ⊗ I) w),   (ω, α)⁺ = the chain's other rows

A constant error of the attitude costs no noise and shows in no rate: a gyroscope alone tells
nothing of tilt or heading, as it should. (White jerk on Euler angles makes it an inclinometer.)

A tangent vector of the attitude is a tilt about a level axis, in a frame N that goes with the
heading, and then a turn about the vertical (`models.attitude.turn`); v and a turn with it:

    retract(x, d): R⁺ = W R, v⁺ = W v + d_v, a⁺ = W a + d_a, else added
                   W = Exp(d₃ e_z) Exp(N (d₁, d₂, 0))

So what an accelerometer reads of a does not depend on the attitude's part; turning about the
vertical, which no inertial sensor shows, is the same tangent vector of attitude, v and a at every
state; and what is known of a tilt beside an accelerometer's bias stays so wherever the heading
goes. In the body's axes updates made an estimator believe in a heading, in the world's in a tilt.
(Turning the tip too is worse: errors of truths drawn from the model are then larger than claimed.)

A magnetometer leaves the turn about the field unseen, an axis of the world. With one N are the
world's axes: in a frame that goes with the heading that axis moves with every update, and an
estimator believes in a heading.

References
----------
Barrau, Bonnabel (2017), The invariant extended Kalman filter as a stable observer, IEEE Trans.
Automatic Control 62(4): errors whose unseen directions do not depend on the estimate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from models import attitude
from models.chains import Chain
from models.level import UP
from models.rotation import cross_matrix
from models.sensor_kinds.mounted import Vector3

TIP, SIGMA, V, OMEGA, A, ALPHA = (slice(3 * i, 3 * i + 3) for i in range(6))
N_FREE = 18
ORIGIN: Vector3 = (0.0, 0.0, 0.0)
Frame = Callable[[ca.SX], ca.SX]
"""Attitude σ (3,) → the axes (3, 3) of tilts: `models.attitude.heading` or `fixed`."""

STATES: tuple[tuple[str, str], ...] = tuple(
    (pattern.format(axis), unit)
    for pattern, unit in (
        ("tip_{}_m", "m"),
        ("mrp_{}", "1"),
        ("tip_{}_velocity_m_s", "m/s"),
        ("body_rate_{}_rad_s", "rad/s"),
        ("tip_{}_acceleration_m_s2", "m/s²"),
        ("body_acceleration_{}_rad_s2", "rad/s²"),
    )
    for axis in "xyz"
)
"""(name, unit) of every state but biases."""


@dataclass(frozen=True)
class FreeBody:
    """A rigid body in symbols of x (18,); implements `models.kinematics.Body`."""

    x: ca.SX

    @property
    def tip(self) -> ca.SX:
        """World position (3,), m."""
        return self.x[TIP]

    @property
    def tip_velocity(self) -> ca.SX:
        """World velocity (3,), m/s."""
        return self.x[V]

    @property
    def world_to_body(self) -> ca.SX:
        """B (3, 3)."""
        return attitude.body_to_world(self.x[SIGMA]).T

    def point(self, mounting: ca.SX) -> ca.SX:
        """Return the world position (3,) of a point given in body coordinates, m."""
        return self.tip + self.world_to_body.T @ mounting

    def specific_force(self, mounting: ca.SX, gravity: float, *, up: Vector3 = UP) -> ca.SX:
        """Return B (a + g up) + ([α]× + [ω]×²) d (3,), m/s², in body axes.

        The second derivative of `point` with dR/dt = R [ω]×.
        """
        turning = cross_matrix(self.x[OMEGA])
        lever = cross_matrix(self.x[ALPHA]) + turning @ turning
        return self.world_to_body @ (self.x[A] + gravity * ca.DM(up)) + lever @ mounting

    def body_rate(self) -> ca.SX:
        """Return ω (3,), rad/s: a state, so that a gyroscope says nothing of the attitude."""
        return self.x[OMEGA]


def step(
    x: ca.SX,
    w: ca.SX,
    dt: ca.SX,
    tip: Chain,
    turning: Chain,
    *,
    centre_m: Vector3 = ORIGIN,
) -> ca.SX:
    """Return the 18 states after `dt` seconds with unit noises w (18,).

    Parameters
    ----------
    tip, turning : chains of an axis of the tip, and of an axis of the attitude
    centre_m : where the tip's chain has its zero
    """
    centre = ca.DM(centre_m)
    placed = (x[TIP] - centre, x[V], x[A])
    N = attitude.heading(x[SIGMA])  # the noise goes with it: a pen that is turned is the same pen
    F, G = tip.transition(dt), tip.factor(dt)
    moved = [
        sum((F[i, j] * part for j, part in enumerate(placed)), ca.SX.zeros(3))
        + N @ sum((G[i, j] * w[part] for j, part in enumerate((TIP, V, A))), ca.SX.zeros(3))
        for i in range(3)
    ]
    F, G = turning.transition(dt), turning.factor(dt)
    omega, alpha = x[OMEGA], x[ALPHA]
    noises = [w[SIGMA], w[OMEGA], w[ALPHA]]
    turn, rate, acceleration = (
        F[i, 1] * omega
        + F[i, 2] * alpha
        + sum((G[i, j] * noise for j, noise in enumerate(noises)), ca.SX.zeros(3))
        for i in range(3)
    )
    sigma = attitude.product(x[SIGMA], attitude.exponential(turn))
    return ca.vertcat(centre + moved[0], sigma, moved[1], rate, moved[2], acceleration)


def retract(x: ca.SX, d: ca.SX, *, frame: Frame = attitude.heading) -> ca.SX:
    """Return the states (18,) that a tangent vector (18,) is away; `frame` is that of tilts."""
    turn = attitude.turn(frame(x[SIGMA]), d[SIGMA])
    W = attitude.body_to_world(turn)
    return ca.vertcat(
        x[TIP] + d[TIP],
        attitude.product(turn, x[SIGMA]),
        W @ x[V] + d[V],
        x[OMEGA] + d[OMEGA],
        W @ x[A] + d[A],
        x[ALPHA] + d[ALPHA],
    )


def difference(to: ca.SX, of: ca.SX, *, frame: Frame = attitude.heading) -> ca.SX:
    """Return the tangent vector (18,) from one to another; `frame` is that of tilts."""
    turn = attitude.product(to[SIGMA], -of[SIGMA])
    W = attitude.body_to_world(turn)
    return ca.vertcat(
        to[TIP] - of[TIP],
        attitude.tangent(frame(of[SIGMA]), turn),
        to[V] - W @ of[V],
        to[OMEGA] - of[OMEGA],
        to[A] - W @ of[A],
        to[ALPHA] - of[ALPHA],
    )
