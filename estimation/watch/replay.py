"""The last seconds once more, as a hypothesis has it, and whether all that is kept then fits."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimation.estimate import Estimate
from estimation.estimator import BatchEstimator
from estimation.recording import Measurement
from estimation.watch.hypotheses import Hypothesis
from estimation.watch.livelier import LEVELS, MotionLevels
from estimation.watch.past import Anchor, Past, PastRow, is_before
from estimation.watch.quiet import Quiet
from estimation.watch.reach import Reach
from estimation.watch.statistics import Statistics
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

FITS = 0.85
"""Largest score of a sensor that fits."""
PEAK_S = 0.12
"""So long at its end a replay has to fit."""
FEWEST_SAMPLES, FEWEST_SUDDEN = 3, 8
"""Of a sensor that can be judged; the second behind what began suddenly."""
FREED = 10.0
"""By how many of its prior's standard deviations a bias that is freed may be off."""


@dataclass(frozen=True, eq=False)
class Replayed:
    """What became of a replay.

    Parameters
    ----------
    anchor : where it began
    rows : since then, as they were taken
    inner, estimate : the estimator's state and estimate behind its last row
    memory : of the statistics
    score : the largest of the sensors that are kept, over the last `PEAK_S`; inf where none can be
        judged
    """

    hypothesis: Hypothesis
    anchor: Anchor
    rows: tuple[PastRow, ...]
    inner: Any
    estimate: Estimate
    memory: Array
    score: float

    @property
    def fits(self) -> bool:
        """Whether nothing speaks against the hypothesis."""
        return self.score < FITS


class Replays:
    """Makes replays; one belongs to one watch."""

    def __init__(
        self, model: StateSpaceModel, levels: MotionLevels, statistics: Statistics
    ) -> None:
        self._model, self._levels, self._statistics = model, levels, statistics
        ends = np.cumsum([0, *(sensor.n_y for sensor in model.sensors)])
        self._columns = [slice(a, b) for a, b in itertools.pairwise(ends)]
        self._quiet, self._numbers = Quiet(statistics), np.arange(statistics.n_sensors)
        watched = [sensor.index for sensor in statistics.sensors]
        self._is_watched = np.isin(self._numbers, watched)
        names = model.state_names
        self._biases = [[names.index(b) for b in sensor.bias_states] for sensor in model.sensors]

    def without(self, y: Array, sensors: Sequence[int] | frozenset[int]) -> Array:
        """Return a row without the readings of some sensors."""
        if not sensors:
            return y
        y = y.copy()
        for i in sensors:
            y[self._columns[i]] = np.nan
        return y

    def has_reading(self, y: Array, sensor: int) -> bool:
        """Whether a sensor has a reading in a row."""
        return bool(np.isfinite(y[self._columns[sensor]]).any())

    def start(self, past: Past, level: int, back_s: float) -> Anchor:
        """Return what was known at the beginning of the last `back_s` seconds of rows."""
        newest = max(row.time_s for row in past.rows)
        return self.before(past, level, past.first_since(newest - back_s))

    def before(self, past: Past, level: int, number: int) -> Anchor:
        """Return what was known in front of a row, or of the first that has something before it."""
        oldest = past.anchors[0]
        first = min(max(number, oldest.number + (oldest.gaussian is None)), past.count - 1)
        usable = [each for each in past.anchors if is_before(each, first)]
        anchor = usable[-1] if usable else oldest
        if anchor.gaussian is not None and anchor.number >= first:
            return anchor
        rows = past.since(anchor.number)[: first - anchor.number]
        given = [self.without(row.y, row.unused) for row in rows]
        inner, _, _, (mean, P) = many(self._levels[level], anchor.inner, rows, given)
        return Anchor(first, inner, max(row.time_s for row in rows), GaussianState(mean, P))

    def replayed(
        self,
        past: Past,
        start: Anchor,
        hypothesis: Hypothesis,
        *,
        reach: Reach,
        prior: GaussianState,
        level: int,
        undropped: frozenset[int],
    ) -> Replayed | None:
        """Return what becomes of the rows since `start`; None where that is no start.

        Parameters
        ----------
        level : at which `start` was found
        undropped : sensors whose outliers are taken
        """
        assert start.gaussian is not None
        estimator = self._levels[hypothesis.level]
        known = self._changed(start.gaussian, hypothesis, reach, prior, level)
        rows = past.since(start.number)
        try:
            first = inner = estimator.init(known)
        except InputError:
            return None
        if start.time_s is not None:
            empty = rows[0].y.copy()
            empty[: self._model.n_y] = np.nan
            first, _ = inner, _ = estimator.step(inner, Measurement(start.time_s, empty))
        rows = tuple(
            row._replace(dropped=row.dropped - undropped, out=hypothesis.left_out) for row in rows
        )
        given = [self.without(row.y, row.unused) for row in rows]
        taken, score = self._statistics.first(), 0.0
        fewest = FEWEST_SUDDEN if hypothesis.is_sudden else FEWEST_SAMPLES
        if len(rows) > 1:
            inner, v, S, _ = many(estimator, inner, rows[:-1], given[:-1])
            counts = [row.time_s >= rows[-1].time_s - PEAK_S for row in rows[:-1]]
            score = self._quiet.again(
                taken,
                v,
                S,
                counts=np.array(counts),
                judged=self._is_watched & ~np.isin(self._numbers, list(hypothesis.left_out)),
                fewest=FEWEST_SAMPLES,
            )
        memory = taken.tolist()
        inner, estimate = estimator.step(inner, Measurement(rows[-1].time_s, given[-1]))
        z, far = self._statistics.distances(
            estimate.innovation.tolist(), estimate.innovation_covariance.tolist()
        )
        self._statistics.take(memory, z)
        self._statistics.count_outliers(memory, far, self._statistics.outliers(memory, far))
        anchor = Anchor(start.number, first, start.time_s, known)
        score = max(score, self._score(memory, hypothesis.left_out, fewest, float("inf")))
        return Replayed(hypothesis, anchor, rows, inner, estimate, np.array(memory), score)

    def _changed(
        self,
        known: GaussianState,
        hypothesis: Hypothesis,
        reach: Reach,
        prior: GaussianState,
        level: int,
    ) -> GaussianState:
        if hypothesis.is_restart:
            known = reach.restarted(known, prior)
        P = known.covariance.copy()
        if hypothesis.level > level:
            wider = np.where(reach.moves, LEVELS[hypothesis.level] / LEVELS[level], 1.0)
            P *= np.outer(wider, wider)
        for sensor in hypothesis.freed:
            for i in self._biases[sensor]:
                P[i, i] += FREED**2 * prior.covariance[i, i]
        return GaussianState(known.mean, P)

    def _score(
        self, memory: list[float], left_out: frozenset[int], fewest: int, unjudged: float
    ) -> float:
        scores = self._statistics.scores(memory)
        samples = memory[self._statistics.layout.slices["samples"]]
        judged = [
            scores[each.index]
            for each in self._statistics.sensors
            if each.index not in left_out and samples[each.index] >= fewest
        ]
        return max(judged, default=unjudged)


def many(
    estimator: Any, inner: Any, rows: Sequence[PastRow], given: Sequence[Array]
) -> tuple[Any, Array, Array, tuple[Array, Array]]:
    """Return the state behind rows, innovations and their S, and the last mean and covariance."""
    if isinstance(estimator, BatchEstimator):
        times = np.array([row.time_s for row in rows])
        inner, history = estimator.batch(inner, times, np.array(given), covariances=True)
        last = (history.mean[-1], history.covariance[-1])
        return inner, history.innovation, history.innovation_covariance, last
    v, S = [], []
    for row, y in zip(rows, given, strict=True):
        inner, estimate = estimator.step(inner, Measurement(row.time_s, y))
        v.append(estimate.innovation)
        S.append(estimate.innovation_covariance)
    last = (estimate.state.mean, estimate.state.covariance)
    return inner, np.array(v), np.array(S), last
