"""Symbolic rigid-body kinematics: one time derivative, every inertial sensor.

A sensor at mounting vector d is at ``p_s = p_tip + Bᵀ d``; its specific force
and the body rate follow by differentiating along the state:

    f_b = B (p̈_s + g up),      [ω_b]× = B dBᵀ/dt

up is (0, 0, 1) in a world that is level, see `models.level`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import casadi as ca

from models.level import UP, Vector3
from models.rotation import vee


class Body(Protocol):
    """What sensors can be mounted on: a rigid body, or one that reads as a paper prints it."""

    @property
    def tip(self) -> ca.SX:
        """World position (3,) of the origin, m."""

    @property
    def tip_velocity(self) -> ca.SX:
        """World velocity (3,) of the origin, m/s."""

    @property
    def world_to_body(self) -> ca.SX:
        """The rotation matrix B (3, 3)."""

    def point(self, mounting: ca.SX) -> ca.SX:
        """Return the world position (3,) of a point given in body coordinates, m."""

    def specific_force(self, mounting: ca.SX, gravity: float, *, up: Vector3 = UP) -> ca.SX:
        """Return what an accelerometer at `mounting` reads, in body axes (3,), m/s².

        Parameters
        ----------
        up : unit vector against gravity, in world axes
        """

    def body_rate(self) -> ca.SX:
        """Return what a gyroscope reads, in body axes (3,), rad/s."""


@dataclass(frozen=True)
class RigidBody:
    """A rigid body that moves along its degrees of freedom q, q̇, q̈.

    Parameters
    ----------
    q, q_dot, q_ddot : (n_q,) symbols: coordinates (m, rad), rates and accelerations
    tip : (3,) expression of q, m: position of the body's origin in the world
    world_to_body : (3, 3) expression of q: B
    """

    q: ca.SX
    q_dot: ca.SX
    q_ddot: ca.SX
    tip: ca.SX
    world_to_body: ca.SX

    def time_derivative(self, expression: ca.SX) -> ca.SX:
        """Return d/dt of an expression of q and q̇: Σ ∂/∂q · q̇ + ∂/∂q̇ · q̈."""
        along = ca.jtimes(ca.vec(expression), self._coordinates, self._velocities)
        return ca.reshape(along, expression.shape)

    @property
    def tip_velocity(self) -> ca.SX:
        """World velocity (3,) of the origin, m/s."""
        return self.time_derivative(self.tip)

    def point(self, mounting: ca.SX) -> ca.SX:
        """Return the world position (3,) of a point given in body coordinates, m."""
        return self.tip + self.world_to_body.T @ mounting

    def specific_force(self, mounting: ca.SX, gravity: float, *, up: Vector3 = UP) -> ca.SX:
        """Return what an accelerometer at `mounting` reads, in body axes, m/s²."""
        acceleration = self.time_derivative(self.time_derivative(self.point(mounting)))
        return self.world_to_body @ (acceleration + gravity * ca.DM(up))

    def body_rate(self) -> ca.SX:
        """Return the angular rate in body axes (3,), rad/s."""
        return vee(self.world_to_body @ self.time_derivative(self.world_to_body.T))

    @property
    def _coordinates(self) -> ca.SX:
        return ca.vertcat(self.q, self.q_dot)

    @property
    def _velocities(self) -> ca.SX:
        return ca.vertcat(self.q_dot, self.q_ddot)
