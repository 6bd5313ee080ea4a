"""A watch without replays around an estimator in Python: what an export with a watch has to say."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from codegen.watching import ALONE
from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from estimation.watch.energy import is_livelier, is_only_energy
from estimation.watch.flags import Flag
from estimation.watch.limits import limits_of
from estimation.watch.reach import Reach
from estimation.watch.statistics import Statistics
from models.arrays import Array

STUCK, OUTLIER, INCONSISTENT = (
    np.uint8(flag) for flag in (Flag.STUCK, Flag.OUTLIER, Flag.INCONSISTENT)
)
OUT = np.uint8(Flag.INCONSISTENT | Flag.LEFT_OUT)


class WatchAlone:
    """Steps of an estimator; `memory` is that of `Statistics`."""

    def __init__(self, estimator: Any) -> None:
        self.estimator, model = estimator, estimator.model
        self.statistics, self.reach = Statistics(model, limits_of(model)), Reach(model)
        self.memory, self.state = self.statistics.first(), estimator.init()
        n = len(model.sensors)
        self.columns = {s.index: slice(s.columns.start, s.columns.stop) for s in self.watched}
        self.out_s: dict[int, float] = {}
        self.begun_s = self.newest_s = self.alarm_s = np.nan
        self.known, self.lost, self.n = model.prior.std < self.reach.found, False, n

    @property
    def watched(self) -> Iterator[Any]:
        return iter(self.statistics.sensors)

    def step(self, time_s: float, y: Array) -> tuple[Estimate, Status, Array]:
        """Take a row; return the estimate, the words of the watch, and flags (n_sensors,)."""
        statistics, flagged = self.statistics, np.zeros(self.n, dtype=np.uint8)
        is_late, y = time_s < self.newest_s, y.copy()
        stuck = [] if is_late else statistics.repeats(self.memory, time_s, y)
        flagged[stuck] |= STUCK
        flagged[list(self.out_s)] |= OUT
        if np.isnan(self.begun_s):
            self.begun_s = time_s
        is_calm = time_s - self.begun_s < ALONE["CALM_S"]
        for i in stuck:
            y[self.columns[i]] = np.nan
        state, estimate = self.estimator.step(self.state, Measurement(time_s, y))
        z, far = statistics.distances(estimate.innovation, estimate.innovation_covariance)
        outliers = [] if is_calm else statistics.outliers(self.memory, far)
        flagged[outliers] |= OUTLIER
        without = y.copy()
        for i in {*outliers, *self.out_s}:
            without[self.columns[i]] = np.nan
        for sensor in self.watched:
            if sensor.index in outliers:
                z[sensor.rows.start : sensor.rows.stop] = [np.nan] * len(sensor.rows)
        if not np.array_equal(without, y, equal_nan=True):
            state, estimate = self.estimator.step(self.state, Measurement(time_s, without))
        statistics.take(self.memory, z)
        statistics.count_outliers(self.memory, far, outliers)
        words = (Status.STUCK if stuck else Status.SOLVED) | (
            Status.OUTLIER if outliers else Status.SOLVED
        )
        if not is_calm:
            words |= self._judged(time_s, flagged)
        if self._is_lost(estimate.state.std):
            words |= Status.LOST
        self.state = state
        self.newest_s = time_s if np.isnan(self.newest_s) else max(time_s, self.newest_s)
        return estimate, words, flagged

    def _judged(self, time_s: float, flagged: Array) -> Status:
        statistics, memory, scores = self.statistics, self.memory, None
        scores = statistics.scores(memory)
        out = set(self.out_s)
        kept = [sensor.index for sensor in self.watched if sensor.index not in out]
        alarms = [i for i in kept if scores[i] > 1]
        for i in out:
            if scores[i] > 1:
                statistics.forget(memory, i)
                self.out_s[i] = time_s
            elif (
                time_s - self.out_s[i] >= ALONE["RETURN_S"]
                and scores[i] < ALONE["RETURNS"]
                and statistics.layout.view(memory, "samples")[i] >= ALONE["FEWEST_SAMPLES"]
            ):
                del self.out_s[i]
        if not alarms:
            self.alarm_s = np.nan
            return Status.SOLVED
        if is_livelier(statistics, memory, out):
            return Status.LIVELIER
        if is_only_energy(statistics, memory, out):
            if np.isnan(self.alarm_s):
                self.alarm_s = time_s
            if time_s - self.alarm_s < ALONE["WAIT_S"]:
                return Status.SOLVED
        if len(alarms) == 1 and len(kept) > 1:
            self.out_s[alarms[0]], self.alarm_s = time_s, np.nan
            flagged[alarms[0]] |= OUT
            statistics.forget(memory, alarms[0])
            return Status.SOLVED
        flagged[alarms] |= INCONSISTENT
        return Status.INCONSISTENT

    def _is_lost(self, std: Array) -> bool:
        asked = self.reach.components
        is_found = std < self.reach.found
        if self.lost:
            self.lost = not (is_found | ~self.known)[asked].all()
        else:
            self.lost = bool((self.known & (std > self.reach.lost))[asked].any())
        self.known[asked] |= is_found[asked]
        return self.lost
