"""Instants in which nothing stands out: many, or one, in a call of C where there is a compiler."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimation.chosen import chosen
from estimation.watch.asked import NEVER_CALMER, Calmer, Known, Marks
from estimation.watch.compiled import CompiledStatistics
from estimation.watch.energy import is_calm
from estimation.watch.statistics import Statistics
from estimation.watch.watchable import Numbers
from models.arrays import Array


class Quiet:
    """Takes instants into the memory of statistics, as far as nothing stands out."""

    def __init__(self, statistics: Statistics) -> None:
        self._statistics = statistics
        self._compiled = chosen(lambda: CompiledStatistics(statistics), lambda: None)

    def clean(
        self,
        memory: Array,
        time_s: Array,
        y: Array,
        v: Array,
        S: Array,
        *,
        newest_s: float,
        calmer: Calmer = NEVER_CALMER,
    ) -> int:
        """Take instants into `memory` up to the first in which something stands out.

        That is a sensor that is stuck, an outlier, a score above 1, or that all would be usual in a
        calmer motion. Returns how many they are.

        Parameters
        ----------
        time_s, y : (n,), (n, n_row)
        v, S : (n, n_r), (n, n_r, n_r) of the estimates
        newest_s : the newest instant before
        """
        if self._compiled is not None:
            return self._compiled.clean(memory, time_s, y, v, S, newest_s=newest_s, calmer=calmer)
        now = memory.tolist()
        rows = zip(time_s.tolist(), y.tolist(), v.tolist(), S.tolist(), strict=True)
        for k, (t, *row) in enumerate(rows):
            before = now.copy()
            if not self._is_clean(now, t < newest_s, t, *row) or (
                calmer.factor > 0
                and not t - calmer.since_s < calmer.after_s
                and is_calm(self._statistics, now, calmer.factor)
            ):
                memory[:] = before
                return k
            newest_s = max(newest_s, t)
        memory[:] = now
        return len(time_s)

    def one(
        self,
        memory: Array,
        time_s: float,
        y: Array,
        v: Array,
        S: Array,
        *,
        calmer: Calmer,
        known: Known,
    ) -> tuple[Array, Array] | None:
        """Return what is remembered behind one instant, not late, and the deviations (n_x,).

        None where something stands out, or what is known changes; see `clean`.
        """
        if self._compiled is not None:
            return self._compiled.one(memory, time_s, y, v, S, calmer=calmer, known=known)
        std, after = np.sqrt(known.covariance.diagonal()), memory.copy()
        asked = ~np.isnan(known.limit)
        for each in (std, known.std):
            if ((each < known.limit) != known.known)[asked].any():
                return None
        rows = np.array([time_s]), y[None], v[None], S[None]
        is_clean = self.clean(after, *rows, newest_s=time_s, calmer=calmer)
        return (after, std) if is_clean else None

    def again(
        self, memory: Array, v: Array, S: Array, *, counts: Marks, judged: Marks, fewest: int
    ) -> float:
        """Take samples into `memory`, whatever stands out; return the largest score, 0 for none.

        Parameters
        ----------
        v, S : (n, n_r), (n, n_r, n_r)
        counts : (n,) behind which scores are looked at
        judged : (n_sensors,) whose scores are
        fewest : samples of a sensor that can be judged
        """
        if self._compiled is not None:
            return self._compiled.again(memory, v, S, counts=counts, judged=judged, fewest=fewest)
        now, most, samples = memory.tolist(), 0.0, self._statistics.layout.slices["samples"].start
        for innovation, covariance, is_counted in zip(v.tolist(), S.tolist(), counts, strict=True):
            z, _ = self._statistics.distances(innovation, covariance)
            self._statistics.take(now, z)
            if not is_counted:
                continue
            scores = self._statistics.scores(now)
            known = (i for i in np.flatnonzero(judged) if now[samples + i] >= fewest)
            most = max(most, max((scores[i] for i in known), default=0.0))
        memory[:] = now
        return most

    def _is_clean(
        self,
        memory: list[float],
        is_late: bool,
        t: float,
        y: Numbers,
        v: Numbers,
        S: Sequence[Numbers],
    ) -> bool:
        if not is_late and self._statistics.repeats(memory, t, y):
            return False
        z, far = self._statistics.distances(v, S)
        if self._statistics.outliers(memory, far):
            return False
        self._statistics.take(memory, z)
        self._statistics.count_outliers(memory, far, ())
        return not max(self._statistics.scores(memory)) > 1
