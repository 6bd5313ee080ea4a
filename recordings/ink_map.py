"""The nearest ink of any point on the paper: to half a millimetre by one look-up, or exactly."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from models.arrays import Array

CELL_MM = 0.25
MARGIN_MM = 20.0


class InkMap:
    """A grid over the ink whose cells know the cell of the nearest ink, and a tree of the ink.

    Parameters
    ----------
    ink_mm : (n, 2)
    """

    def __init__(self, ink_mm: Array) -> None:
        self.ink_mm, self.tree = ink_mm, cKDTree(ink_mm)
        self._corner = ink_mm.min(axis=0) - MARGIN_MM
        extent = ink_mm.max(axis=0) + MARGIN_MM - self._corner
        empty = np.ones(np.ceil(extent / CELL_MM).astype(int) + 1, dtype=bool)
        empty[tuple(self._cells(ink_mm, empty.shape).T)] = False
        self._nearest = distance_transform_edt(
            empty, return_distances=False, return_indices=True
        ).transpose(1, 2, 0)

    def nearest(self, points_mm: Array) -> Array:
        """Return the middle (n, 2) of the cell with the nearest ink, for points (n, 2).

        A point beyond the margin is given the ink nearest to the margin's edge.
        """
        cells = self._cells(points_mm, self._nearest.shape[:2])
        return np.asarray(self._corner + (self._nearest[tuple(cells.T)] + 0.5) * CELL_MM)

    def _cells(self, points_mm: Array, shape: tuple[int, ...]) -> Array:
        cells = np.floor((points_mm - self._corner) / CELL_MM).astype(int)
        return np.clip(cells, 0, np.array(shape) - 1)
