"""From a truth's frame into the estimate's.

    tip = W (p + R l) + s        R_pen = W R M

with W the turn between both worlds, s a shift, and, where the truth is of a marker that is fixed to
the pen somehow, M its turn on the pen and l the way from it to the tip, in the marker's axes. A
tablet whose y points down is one whose z does: no frame is mirrored.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from models.arrays import Array

UPS = tuple(sign * axis for axis in np.eye(3)[[2, 1, 0]] for sign in (1.0, -1.0))
"""Axes that may point against gravity, the likely ones first."""


@dataclass(frozen=True, eq=False)
class Frame:
    """How a truth's frame lies in the estimate's; by default as it.

    Parameters
    ----------
    world : W (3, 3)
    shift : s (3,), m
    mount : M (3, 3)
    lever : l (3,), m
    """

    world: Array = field(default_factory=lambda: np.eye(3))
    shift: Array = field(default_factory=lambda: np.zeros(3))
    mount: Array = field(default_factory=lambda: np.eye(3))
    lever: Array = field(default_factory=lambda: np.zeros(3))

    def tips(self, positions: Array, attitudes: Array | None) -> Array:
        """Return the tip (n, 3) of positions (n, 2) or (n, 3) and attitudes (n, 3, 3)."""
        p = np.pad(positions, ((0, 0), (0, 3 - positions.shape[1])))
        if attitudes is not None:
            p = p + attitudes @ self.lever
        return np.asarray(p @ self.world.T + self.shift)

    def turned(self, attitudes: Array) -> Array:
        """Return the pen's attitude (n, 3, 3) of the truth's."""
        return np.asarray(self.world @ attitudes @ self.mount)

    def moved(self, turn: Array, shift: Array, mount: Array, lever: Array) -> Frame:
        """Return a frame nearby: turns are rotation vectors (3,)."""
        return replace(
            self,
            world=Rotation.from_rotvec(turn).as_matrix() @ self.world,
            shift=self.shift + shift,
            mount=self.mount @ Rotation.from_rotvec(mount).as_matrix(),
            lever=self.lever + lever,
        )

    @property
    def heading_rad(self) -> float:
        """The turn about the vertical that is left when the axis upwards is laid on it."""
        level = self.world @ upright(self.up).T
        return float(np.arctan2(level[1, 0], level[0, 0]))

    @property
    def up(self) -> Array:
        """The truth's direction against gravity (3,)."""
        return np.asarray(self.world.T[:, 2])


def about_vertical(angle: float) -> Array:
    """Return the turn (3, 3) by an angle, rad, about the vertical."""
    return np.asarray(Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix())


def upright(up: Array) -> Array:
    """Return the shortest turn (3, 3) that lays a direction on the vertical."""
    z = np.array([0.0, 0.0, 1.0])
    axis, cosine = np.cross(up, z), float(up @ z)
    if np.linalg.norm(axis) < 1e-9:
        return np.eye(3) if cosine > 0 else np.diag([1.0, -1.0, -1.0])
    turn = axis / np.linalg.norm(axis) * np.arccos(np.clip(cosine, -1, 1))
    return np.asarray(Rotation.from_rotvec(turn).as_matrix())
