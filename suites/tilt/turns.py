"""Turns of a carrier: its two tilts and their rates, smooth, from rest to rest.

    angle(τ) = start + turn s(τ) + swing w(τ) sin(2π (n τ + phase)),   0 ≤ τ ≤ 1
    s = 10 τ³ - 15 τ⁴ + 6 τ⁵ (minimum jerk),   w = sin²(π τ)

with some rest before and after.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from models.arrays import Array


@dataclass(frozen=True)
class Tilting:
    """What one tilt does.

    Parameters
    ----------
    start_deg : where it begins
    turn_deg : how far it turns in all
    swing_deg : amplitude of its swing to and fro
    swings : number n of swings
    phase : of the swing, in turns
    """

    start_deg: float = 0.0
    turn_deg: float = 0.0
    swing_deg: float = 0.0
    swings: float = 4.0
    phase: float = 0.0

    def __call__(self, tau: Array) -> tuple[Array, Array]:
        """Return angle, rad, and its derivative by τ, both (n,), at τ (n,)."""
        turned = 10 * tau**3 - 15 * tau**4 + 6 * tau**5
        turning = 30 * tau**2 - 60 * tau**3 + 30 * tau**4
        window, opening = np.sin(math.pi * tau) ** 2, math.pi * np.sin(2 * math.pi * tau)
        at, speed = 2 * math.pi * (self.swings * tau + self.phase), 2 * math.pi * self.swings
        swung = window * np.sin(at)
        swinging = opening * np.sin(at) + window * speed * np.cos(at)
        angle = self.start_deg + self.turn_deg * turned + self.swing_deg * swung
        return np.radians(angle), np.radians(self.turn_deg * turning + self.swing_deg * swinging)


@dataclass(frozen=True)
class Turn:
    """A motion of the carrier.

    Parameters
    ----------
    phi, theta : tilts as of `models.turntable`: θ about the body axis x, φ about a level axis
    moving_s : duration of the motion; shorter is faster
    resting_s : before it, and after it
    """

    phi: Tilting = Tilting()
    theta: Tilting = Tilting()
    moving_s: float = 10.0
    resting_s: float = 1.0

    @property
    def duration_s(self) -> float:
        """With the rest before and after."""
        return self.moving_s + 2 * self.resting_s

    def states(self, time_s: Array) -> Array:
        """Return (φ, θ, φ̇, θ̇) (n, 4), rad and rad/s, at instants (n,)."""
        tau = np.clip((time_s - self.resting_s) / self.moving_s, 0.0, 1.0)
        (phi, phi_turning), (theta, theta_turning) = self.phi(tau), self.theta(tau)
        return np.column_stack(
            [phi, theta, phi_turning / self.moving_s, theta_turning / self.moving_s]
        )


def gravity_direction(phi: Array, theta: Array) -> Array:
    """Return R (n, 3): what a resting accelerometer reads in body axes, normalised."""
    return np.column_stack([np.sin(phi), np.cos(phi) * np.sin(theta), np.cos(phi) * np.cos(theta)])


def tilts_of(directions: Array) -> tuple[Array, Array]:
    """Return φ in -π/2 to π/2 and θ in -π to π, both (n,), of directions (n, 3)."""
    x, y, z = directions.T
    return np.arctan2(x, np.hypot(y, z)), np.arctan2(y, z)
