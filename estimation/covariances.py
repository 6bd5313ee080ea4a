"""Full covariances of a run, for whoever asks to keep them."""

from __future__ import annotations

from dataclasses import dataclass

from models.arrays import Array


@dataclass(frozen=True, eq=False)
class Covariances:
    """Full covariances of a run: of states (n, n_x, n_x) and of innovations (n, n_r, n_r)."""

    state: Array
    innovation: Array
