"""From a pen's angles, rates and accelerations to the vectors of its body, in NumPy and SciPy only.

With ω₀ = (-cosθ φ̇, -θ̇, sinθ φ̇), the body's rate without spin as the equations write it out, and
Z(ψ) the change of coordinates into axes turned by the spin,

    ω = Z(ψ) ω₀ + ψ̇ e_z,     α = Z(ψ) (ω̇₀ - ψ̇ e_z × ω₀) + ψ̈ e_z
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

N_FREE = 18


def body_to_world(azimuth: Array, elevation: Array, spin: Array) -> Rotation:
    """Rotations of pens (n,).

    A pen at elevation π/2, azimuth 0 and spin 0 has the world's axes for its own; it leans by
    π/2 - θ about y, and what is turned first about its own axis is turned by the spin.
    """
    angles = np.column_stack([azimuth, np.pi / 2 - np.asarray(elevation), spin])
    return Rotation.from_euler("ZYZ", angles)


def free_states(euler: Array) -> Array:
    """Return (n, 18) states (p, σ, v, ω, a, α) of states (n, 18) of coordinates (q, q̇, q̈).

    Biases behind either stay as they are.
    """
    angles, rates, accelerations = euler[:, 3:6], euler[:, 9:12], euler[:, 15:18]
    sin, cos = np.sin(angles[:, 1]), np.cos(angles[:, 1])
    phi, theta, psi = rates.T
    phi_2, theta_2, psi_2 = accelerations.T
    unspun = np.column_stack([-cos * phi, -theta, sin * phi])
    unspun_dot = np.column_stack(
        [sin * theta * phi - cos * phi_2, -theta_2, cos * theta * phi + sin * phi_2]
    )
    e_z = np.array([0.0, 0.0, 1.0])
    into_spun = Rotation.from_euler("z", -angles[:, 2:])
    along = into_spun.apply(unspun_dot - np.cross(psi[:, None] * e_z, unspun))
    states = np.array(euler, dtype=float)
    states[:, 3:6] = body_to_world(*angles.T).as_mrp()
    states[:, 9:12] = into_spun.apply(unspun) + psi[:, None] * e_z
    states[:, 15:18] = along + psi_2[:, None] * e_z
    return states


def free_state(euler: Array) -> Array:
    """Return the same of one state (18 and biases,)."""
    return np.asarray(free_states(np.asarray(euler, dtype=float)[None])[0])


def still_state(elevation: float, azimuth: float = 0.0, spin: float = 0.0) -> Array:
    """Return a pen (18,) that does not move, its tip at the origin."""
    euler = np.zeros(N_FREE)
    euler[3:6] = azimuth, elevation, spin
    return free_state(euler)
