"""The log of ekf_baseline/late.c in Python: the last rows in order of capture, in a flat state.

Its functions are those of the C, which says what they do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ekf_baseline.state import Kept
from estimation.kalman_stage import rows_present
from estimation.layout import Layout
from models.arrays import Array
from models.state_space import StateSpaceModel


class Log:
    """The log of one state, changed in place.

    Parameters
    ----------
    memory : the flat state whose log it is
    """

    def __init__(self, model: StateSpaceModel, kept: Kept, layout: Layout, memory: Array) -> None:
        self._model, self._kept = model, kept
        self._inputs = layout.slices["inputs"]
        self._count, times, self.steps, self.rows, self.checkpoints = (
            layout.view(memory, block)
            for block in ("count", "times", "steps", "rows", "checkpoints")
        )
        self._before, self.times = times[:1], times[1:]

    def __len__(self) -> int:
        return int(self._count[0]) if self._kept.capacity else 0

    def append(self, own: Array, time_s: float, dt: float, y: Array) -> None:
        """Log a row behind all others; `own` is the filter's state before it."""
        if not self._kept.capacity:
            return
        if len(self) == self._kept.capacity:
            self._forget()
        n = len(self)
        if n == 0:
            self._before[0] = own[0]
        if n % self._kept.spacing == 0:
            self.checkpoints[n // self._kept.spacing] = own
        self.times[n], self.steps[n], self.rows[n] = time_s, dt, y
        self._count += 1

    def insert(self, time_s: float, y: Array) -> tuple[int, NDArray[np.bool_]] | None:
        """Log a late row where it belongs.

        Returns
        -------
        Its place, and which rows of the residual (n_r,) it may bring; None where it is older than
        the log.
        """
        count, model, spacing = len(self), self._model, self._kept.spacing
        if count == 0 or self._before[0] >= time_s:
            return None
        times = self.times[:count]
        for k in np.flatnonzero(times == time_s)[::-1]:
            if may_join(self._model, self.rows[k], y):
                return int(k), self._joined(k, y)
        place = int(np.searchsorted(times, time_s, side="right"))
        known = np.isfinite(y[model.n_y :]) | np.isfinite(self.checkpoints[0][self._inputs])
        if place == 0 and not known.all():
            return None
        if count == self._kept.capacity:
            if place < spacing:
                return None
            self._forget()
            place -= spacing
        self._move(place, 1)
        before = self.times[place - 1] if place else self._before[0]
        self.times[place], self.rows[place] = time_s, y
        self.steps[place] = 0.0 if np.isnan(before) else time_s - before
        self.steps[place + 1] = self.times[place + 1] - time_s
        return place, np.ones(model.n_r, dtype=bool)

    def _joined(self, k: int, y: Array) -> NDArray[np.bool_]:
        row = self.rows[k]
        before = rows_present(self._model, row)
        row[:] = joined(row, y)
        return rows_present(self._model, row) & ~before

    def _forget(self) -> None:
        spacing = self._kept.spacing
        self._before[0] = self.times[spacing - 1]
        self.checkpoints[:-1] = self.checkpoints[1:].copy()
        self._move(spacing, -spacing)

    def _move(self, first: int, by: int) -> None:
        """Move rows from `first` to before the newest by some rows."""
        end = len(self)
        for block in (self.times, self.steps, self.rows):
            block[first + by : end + by] = block[first:end].copy()
        self._count += by


def may_join(model: StateSpaceModel, row: Array, y: Array) -> bool:
    """Whether a late row (n_row,) brings only what its instant's has not, and the same inputs."""
    both = ~np.isnan(row) & ~np.isnan(y)
    return not (both[: model.n_y].any() or (both & (row != y))[model.n_y :].any())


def joined(row: Array, y: Array) -> Array:
    """Return a row with what a late one brings."""
    return np.where(np.isnan(row), y, row)
