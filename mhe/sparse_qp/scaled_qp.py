"""A linearised window in the units of its QP; `mhe.sparse_qp.osqp_window` has the equations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from mhe.sparse_qp.linearised_window import Linearised
from mhe.sparse_qp.pattern import QpPattern
from models.arrays import Array


@dataclass(frozen=True, eq=False)
class ScaledQp:
    """Values of one QP, and the way there and back.

    Parameters
    ----------
    pattern : of its model and length
    linear : the window
    L : (n_x, n_x) Cholesky factor of the prior's covariance
    d : (n_x,) deviation of the trajectory from the prior's mean
    noise_scale : (n - 1, n_w) diagonals of D
    state_scale : (n_x,) diagonal of S
    """

    pattern: QpPattern
    linear: Linearised
    L: Array
    d: Array
    noise_scale: Array
    state_scale: Array

    @cached_property
    def row_scale(self) -> Array:
        """(n, n_c) ρ: one over the length of a constraint row; 1 where it has no slope."""
        length = np.linalg.norm(self.linear.C * self.state_scale[:, None], axis=1)
        return np.asarray(1 / np.where(length > 0, length, 1.0))

    @cached_property
    def values(self) -> Array:
        """Nonzeros of A."""
        linear, S = self.linear, self.state_scale
        return self.pattern.values(
            self.L / S[:, None],
            linear.F * (S / S[:, None]),
            linear.GD / S[:, None],
            linear.H * S,
            linear.C * S[:, None] * self.row_scale[:, None, :],
        )

    @property
    def is_finite(self) -> bool:
        """Whether OSQP can be given it."""
        linear = self.linear
        parts = (self.values, self.d, linear.b, linear.v, linear.g)
        return all(bool(np.isfinite(part).all()) for part in parts)

    def limits(self, demanded: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Return l and u of l ≤ A z ≤ u, with the rows (n, n_c) that are demanded."""
        linear, rows, S = self.linear, self.pattern.rows, self.state_scale
        upper = np.zeros(rows.size)
        rows.view(upper, "prior")[:] = -self.d / S
        rows.view(upper, "steps")[:] = linear.b / S
        rows.view(upper, "readings")[:] = linear.v
        lower = upper.copy()
        below = -self.row_scale * linear.g
        rows.view(upper, "constraints")[:] = np.where(demanded, below, np.inf)
        rows.view(lower, "constraints")[:] = -np.inf
        return lower, upper

    def variables(self, delta: Array, w: Array) -> Array:
        """Return z of deviations δ (n, n_x) and noises w (n - 1, n_w)."""
        at, linear = self.pattern.variables, self.linear
        z = np.zeros(at.size)
        at.view(z, "u")[:] = solve_triangular(self.L, self.d + delta[0], lower=True)
        at.view(z, "delta")[:] = delta / self.state_scale
        at.view(z, "noise")[:] = w / self.noise_scale
        at.view(z, "residual")[:] = linear.v - np.einsum("kij,kj->ki", linear.H, delta)
        return z

    def deviations(self, z: Array) -> tuple[Array, Array]:
        """Return δ and w of z."""
        at = self.pattern.variables
        return at.view(z, "delta") * self.state_scale, at.view(z, "noise") * self.noise_scale

    def multipliers(self, y: Array) -> Array:
        """Return ν (n, n_c) of the constraint rows as the model writes them, from those of A."""
        return np.asarray(self.pattern.rows.view(y, "constraints") * self.row_scale)

    def length(self, z: Array, other: Array) -> float:
        """Return how far apart two z are, in standard deviations: of all but the states."""
        away = z - other
        self.pattern.variables.view(away, "delta")[:] = 0
        return float(np.linalg.norm(away))
