"""What the EKF does with readings that are too far off: filter.c's gates and bounds, in Python."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ekf_baseline.outliers import OUTLIERS, needed, squared_distance
from estimation.kalman_stage import KalmanStage, Update
from estimation.square_roots import kept
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class OutlierRules:
    """Gates that open again, and bounded influence, of one filter.

    Parameters
    ----------
    model, stage : of the filter
    gate : limits of squared distances, see `ekf_baseline.outliers.gate_limits`; None has no gate
    huber : (n_sensors,) thresholds of bounded influence; None has none
    """

    model: StateSpaceModel
    stage: KalmanStage
    gate: Array | None
    huber: Array | None

    def _rows(self, used: Array) -> Iterator[tuple[int, bool, NDArray[np.intp]]]:
        """Yield sensors, whether they are measured, and those of their rows that are used."""
        start = 0
        for i, sensor in enumerate(self.model.sensors):
            rows = start + np.flatnonzero(used[start : start + sensor.n_r])
            start += sensor.n_r
            if len(rows):
                yield i, sensor.is_measured, rows

    def _distance(self, update: Update, S: Array, rows: NDArray[np.intp]) -> float:
        S = S[np.ix_(rows, rows)]
        return squared_distance(update.innovation[rows], S, S, 0.0)[0]

    def gated(self, seen: Array, update: Update, used: Array, doubt: Array, dt: float) -> Array:
        """Take rows of sensors whose readings are too far off out of `used`, in place.

        Parameters
        ----------
        seen, doubt : see `ekf_baseline.state.EkfState`; the second changes in place

        Returns
        -------
        (n_sensors,) 1 where a gate opens, else 0
        """
        assert self.gate is not None
        opens = np.zeros(len(self.model.sensors))
        count, time_s = doubt[0::2], doubt[1::2]
        time_s[count > 0] += dt
        for i, is_measured, rows in list(self._rows(used)):
            limit = self.gate[i, len(rows)]
            is_far = self._distance(update, update.innovation_covariance, rows) > limit
            if not is_far or (is_measured and seen[i] == 0):
                count[i] = time_s[i] = 0
            elif count[i] >= OUTLIERS["GATE_REJECTIONS"] and time_s[i] >= OUTLIERS["GATE_DOUBT_S"]:
                count[i] = time_s[i] = 0
                opens[i] = 1
            else:
                count[i] += 1
                used[rows] = 0
        return opens

    def widened(
        self, predicted: GaussianState, y: Array, update: Update, opens: Array
    ) -> tuple[GaussianState, Array]:
        """Return the prior, less certain where gates open, and its S; see filter.c.

        Parameters
        ----------
        opens : as `gated` has it
        """
        S, present, share = update.innovation_covariance, update.present.astype(float), 0.0
        if not opens.any():
            return predicted, S
        wide = self.stage.update(self._doubted(predicted, 1.0), y, present).innovation_covariance
        for i, _measured, rows in self._rows(present):
            at, n = np.ix_(rows, rows), len(rows)
            if opens[i] == 0:
                continue
            if self._distance(update, wide, rows) > n:
                share = 1.0
            if share < 1:
                added = (wide - S)[at]
                share = max(share, needed(update.innovation[rows], S[at], added, float(n)))
        prior = self._doubted(predicted, min(share, 1.0))
        return prior, self.stage.update(prior, y, present).innovation_covariance

    def _doubted(self, gaussian: GaussianState, share: float) -> GaussianState:
        """Return a Gaussian with a share of the model's prior on top."""
        total = gaussian.covariance + share * self.model.prior.covariance
        if gaussian.root is None:
            return GaussianState(gaussian.mean, total)
        root = np.asarray(np.linalg.cholesky(total), dtype=np.float64)
        return kept(gaussian.mean, root)

    def bound(self, seen: Array, update: Update, S: Array, used: Array) -> None:
        """Give readings that are too far off less weight in `used`, in place."""
        assert self.huber is not None
        R = np.diag(self.model.noise_std**2)
        for i, is_measured, rows in self._rows(used):
            if is_measured and seen[i] == 0:
                continue
            v, at = update.innovation[rows], np.ix_(rows, rows)
            more = needed(v, S[at], R[at], self.huber[i] ** 2)
            if more > 0:
                used[rows] = np.sqrt(1 / (1 + more))
