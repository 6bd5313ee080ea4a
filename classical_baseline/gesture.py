"""The path of a gesture: acceleration over ground, integrated twice.

    a = Cᵀ f + g_vec,   g_vec = (0, 0, -g)                                              (10)
    v_{k+1} = v_k + (a_k + a_{k+1}) Δt / 2
    p_{k+1} = p_k + v_k Δt + (2 a_k + a_{k+1}) Δt² / 6

with f the specific force at the centre of mass: exact for an acceleration that changes
linearly within a step, of second order otherwise. A tilt error δ adds about g δ.

References
----------
[GyroFree] (9)-(10).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from models.errors import InputError


@dataclass(frozen=True, eq=False)
class GesturePath:
    """Motion over ground: acceleration, velocity and position, each (n, 3), SI, Z up."""

    acceleration: Array
    velocity: Array
    position: Array

    @property
    def length_m(self) -> float:
        """Length of the path."""
        return float(np.linalg.norm(np.diff(self.position, axis=0), axis=1).sum())


def gesture_path(
    C: Array, specific_force: Array, step_s: float, gravity_m_s2: float
) -> GesturePath:
    """Return the path of a gesture that begins at rest in the origin.

    Parameters
    ----------
    C : (n, 3, 3) direction cosines, world to body
    specific_force : (n, 3) of the centre of mass in body axes, m/s²
    step_s : of even samples, s
    gravity_m_s2 : larger than it is lets the path fall

    Raises
    ------
    InputError
        If the direction cosines do not fit the specific forces.
    """
    if not len(specific_force) or C.shape != (len(specific_force), 3, 3):
        raise InputError(
            f"direction cosines have shape {C.shape} for {len(specific_force)} specific forces, "
            "expected (n, 3, 3) for n samples, at least one"
        )
    a = np.einsum("kji,kj->ki", C, specific_force) - [0.0, 0.0, gravity_m_s2]
    v = _summed((a[1:] + a[:-1]) * (step_s / 2))
    p = _summed(v[:-1] * step_s + (2 * a[:-1] + a[1:]) * (step_s**2 / 6))
    return GesturePath(a, v, p)


def _summed(steps: Array) -> Array:
    return np.vstack([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
