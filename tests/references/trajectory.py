"""A pen that moves, in NumPy only: what kinematics in CasADi is compared with.

Nothing here is shared with `models`: the motion is a sum of sines, the
attitude is built from the basis vectors of spherical coordinates and a turn
about the pen's own axis, and every derivative of a position or an attitude is
a five-point central difference in time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.references.free_states import free_state

Array = NDArray[np.float64]

TIME_STEP_S = 5e-4
"""Step of the differences in time. With sines below 20 rad/s truncation and rounding both
stay near 1e-9 m/s² on positions of 0.1 m."""


def first_difference(function: Callable[[float], Array], at: float, step: float) -> Array:
    """Return the five-point central first derivative, exact up to fourth order."""
    outer = function(at - 2 * step) - function(at + 2 * step)
    inner = function(at + step) - function(at - step)
    return np.asarray((outer + 8 * inner) / (12 * step))


def second_difference(function: Callable[[float], Array], at: float, step: float) -> Array:
    """Return the five-point central second derivative, exact up to fifth order."""
    outer = function(at - 2 * step) + function(at + 2 * step)
    inner = function(at - step) + function(at + step)
    return np.asarray((-outer + 16 * inner - 30 * function(at)) / (12 * step**2))


@dataclass(frozen=True)
class SineMotion:
    """q(t) = centre + Σ amplitude · sin(frequency · t + phase), per degree of freedom.

    Parameters
    ----------
    centre : (6,) tip, m, azimuth, elevation, spin, rad
    amplitude, frequency, phase : (6, n) m or rad, rad/s, rad
    """

    centre: Array
    amplitude: Array
    frequency: Array
    phase: Array

    def derivative(self, time_s: float, order: int) -> Array:
        """Return the (6,) time derivative of q of an order; 0 is q itself."""
        # Each derivative of a sine multiplies by its frequency and shifts by a quarter turn.
        angle = self.frequency * time_s + self.phase + order * np.pi / 2
        waves = (self.amplitude * self.frequency**order * np.sin(angle)).sum(axis=1)
        return np.asarray(waves if order else waves + self.centre)

    def state(self, time_s: float, degrees_of_freedom: int) -> Array:
        """Return (q, q̇, q̈) of five degrees of freedom, or (p, σ, v, ω, a, α) of six."""
        n_q = degrees_of_freedom
        coordinates = np.concatenate([self.derivative(time_s, order)[:n_q] for order in range(3)])
        return free_state(coordinates) if n_q == 6 else coordinates

    def body_to_world(self, time_s: float) -> Array:
        """Return the (3, 3) matrix whose columns are the body axes in the world."""
        azimuth, elevation, spin = self.derivative(time_s, 0)[3:]
        e_r = np.array(
            [
                np.cos(elevation) * np.cos(azimuth),
                np.cos(elevation) * np.sin(azimuth),
                np.sin(elevation),
            ]
        )
        e_phi = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        e_theta = np.cross(e_r, e_phi)
        unspun = np.column_stack([-e_theta, e_phi, e_r])
        return np.asarray(Rotation.from_rotvec(spin * e_r).as_matrix() @ unspun)

    def position(self, time_s: float, mounting: Array) -> Array:
        """Return where in the world (3,) a point given in body axes is, m."""
        return np.asarray(self.derivative(time_s, 0)[:3] + self.body_to_world(time_s) @ mounting)

    def specific_force(self, time_s: float, mounting: Array, gravity: float) -> Array:
        """Return the acceleration (3,) of a point minus that of free fall, in body axes, m/s²."""
        acceleration = second_difference(
            lambda t: self.position(t, mounting), time_s, step=TIME_STEP_S
        )
        return np.asarray(
            self.body_to_world(time_s).T @ (acceleration - np.array([0.0, 0.0, -gravity]))
        )

    def body_rate(self, time_s: float) -> Array:
        """Return the angular rate (3,) in body axes, rad/s: Ṙ = [ω_world]× R."""
        rotation_dot = first_difference(self.body_to_world, time_s, step=TIME_STEP_S)
        cross = rotation_dot @ self.body_to_world(time_s).T
        in_world = 0.5 * np.array(
            [cross[2, 1] - cross[1, 2], cross[0, 2] - cross[2, 0], cross[1, 0] - cross[0, 1]]
        )
        return np.asarray(self.body_to_world(time_s).T @ in_world)


def random_motion(rng: np.random.Generator, fixed_spin_rad: float | None = None) -> SineMotion:
    """Return a brisk random motion: centimetres and fractions of a radian at 1 to 3 Hz.

    Parameters
    ----------
    fixed_spin_rad : keeps the spin at a constant; None lets it move
    """
    n_sines = 3
    amplitude = rng.uniform(-1, 1, (6, n_sines)) * np.array([[0.02]] * 3 + [[0.25]] * 3)
    centre = np.concatenate(
        [rng.uniform(-0.1, 0.1, 3), rng.uniform([-np.pi, 0.2, -np.pi], [np.pi, 1.2, np.pi])]
    )
    if fixed_spin_rad is not None:
        amplitude[5], centre[5] = 0.0, fixed_spin_rad
    frequency = rng.uniform(5.0, 19.0, (6, n_sines))
    return SineMotion(centre, amplitude, frequency, rng.uniform(0, 2 * np.pi, (6, n_sines)))
