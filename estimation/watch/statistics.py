"""What a watch remembers of each sensor, and how far from usual that is.

Of a sample with innovation v and S = L Lᵀ over the rows that it has, z = L⁻¹ v, n rows, d² = zᵀ z.
Per sensor and window, with a the weight of a sample:

    m ← (1 - a) m + a z,    mean score |m|² (2 - a) / a
    e ← (1 - a) e + a d²/n,                         energy score e
    b ← (1 - a) b + a [d²/n is much],               of the first window: how busy it is

The mean score is χ² with n degrees of freedom where z is white, once the window is full; m and e
begin at zero, as nothing speaks against a sensor yet. A score is a statistic by its limit: above 1
is an alarm. Repeats are samples that equal the last, or the last but one, in all axes. They count
as long as no `REPEATS_S` pass between two.

Scalar recursions on one flat array, so that statistics.c says the same to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Container, Sequence

import numpy as np

from estimation.layout import Layout
from estimation.watch.limits import MEASURES, REPEATS_S, WINDOWS_S, SensorLimits
from estimation.watch.watchable import Numbers, distances, watchables
from models.arrays import Array
from models.state_space import StateSpaceModel

Flat = list[float] | Array
"""What is remembered: a flat array, or the same numbers as a list, which Python reads faster."""

LIVELIER = 0.5
"""Share of the usual energy of a sensor from which a sample counts as busy."""
REPEATED = ("last", "before_last", "repeats", "repeated_s", "same")
"""Blocks that only readings change, not what was made of them."""


class Statistics:
    """The recursions of the module for the sensors of a model.

    Parameters
    ----------
    limits : one per sensor of the model; None for one that is not watched
    """

    def __init__(self, model: StateSpaceModel, limits: Sequence[SensorLimits | None]) -> None:
        self.model, self.windows, self.n_sensors = model, len(WINDOWS_S), len(model.sensors)
        self.sensors = watchables(model, limits)
        n, windows = self.n_sensors, self.windows
        self.layout = Layout(
            "Watch",
            {
                "samples": (n,),
                "last": (model.n_y,),
                "before_last": (model.n_y,),
                "repeats": (n,),
                "repeated_s": (n,),
                "same": (model.n_y,),
                "outliers": (n,),
                "mean": (windows, model.n_r),
                "energy": (windows, n),
                "busy": (n,),
            },
        )
        self._start = {name: part.start for name, part in self.layout.slices.items()}
        self._n_r = model.n_r

    def first(self) -> Array:
        """Return what is remembered before any sample, (layout.size,)."""
        memory = np.zeros(self.layout.size)
        for block in ("last", "before_last", "repeated_s"):
            self.layout.view(memory, block)[:] = np.nan
        return memory

    def repeats(self, memory: Flat, time_s: float, y: Numbers) -> list[int]:
        """Take the readings of an instant into `memory`; return the sensors that are stuck."""
        stuck, at = [], self._start
        for sensor in self.sensors:
            i, limit = sensor.index, sensor.limits.repeats
            if limit == 0 or not all(math.isfinite(y[c]) for c in sensor.columns):
                continue
            last, before_last = at["last"], at["before_last"]
            if all(y[c] == memory[last + c] for c in sensor.columns) or all(
                y[c] == memory[before_last + c] for c in sensor.columns
            ):
                if not time_s - memory[at["repeated_s"] + i] <= REPEATS_S:
                    memory[at["repeats"] + i] = 0.0
                memory[at["repeats"] + i] += 1.0
                memory[at["repeated_s"] + i] = time_s
                if memory[at["repeats"] + i] >= limit:
                    stuck.append(i)
            is_clipped = False
            for c in sensor.columns:
                same = at["same"] + c
                memory[same] = memory[same] + 1.0 if y[c] == memory[last + c] else 0.0
                is_clipped = is_clipped or memory[same] >= sensor.limits.same
                memory[before_last + c] = memory[last + c]
                memory[last + c] = y[c]
            if is_clipped and i not in stuck:
                stuck.append(i)
        return stuck

    def distances(self, v: Numbers, S: Sequence[Numbers]) -> tuple[list[float], list[float]]:
        """Return z (n_r,), NaN where there is no reading, and d² by its limit (n_sensors,).

        The second is above 1 for an outlier, NaN for a sensor without a sample.
        """
        return distances(self.sensors, self.n_sensors, v, S)

    def take(self, memory: Flat, z: Numbers) -> None:
        """Take an instant's z (n_r,), NaN where there is none, into `memory`."""
        at, n = self._start, self.n_sensors
        for sensor in self.sensors:
            i = sensor.index
            rows = [r for r in sensor.rows if not math.isnan(z[r])]
            if not rows:
                continue
            squared = 0.0
            for r in rows:
                squared += z[r] * z[r]
            squared /= len(rows)
            for w, a in enumerate(sensor.limits.weights):
                b, mean = 1.0 - a, at["mean"] + w * self._n_r
                for r in rows:
                    memory[mean + r] = b * memory[mean + r] + a * z[r]
                energy = at["energy"] + w * n + i
                memory[energy] = b * memory[energy] + a * squared
            a, usual = sensor.limits.weights[0], sensor.limits.usual[len(WINDOWS_S)]
            is_busy = 1.0 if squared > LIVELIER * usual else 0.0
            memory[at["busy"] + i] = (1.0 - a) * memory[at["busy"] + i] + a * is_busy
            memory[at["samples"] + i] += 1.0

    def outliers(self, memory: Numbers, far: Numbers) -> list[int]:
        """Return the sensors whose sample is an outlier beside those before it.

        A body that moves more than its model says is far off sample by sample: no outlier.
        """
        at, found = self._start, list[int]()
        for sensor in self.sensors:
            i = sensor.index
            if far[i] > 1 and memory[at["samples"] + i] > 0:
                energy = memory[at["energy"] + i] / sensor.limits.usual[len(WINDOWS_S)]
                if far[i] > energy:
                    found.append(i)
        return found

    def count_outliers(self, memory: Flat, far: Numbers, outliers: Container[int]) -> None:
        """Count the outliers in a row; `far` as of `distances`."""
        start = self._start["outliers"]
        for sensor in self.sensors:
            i = sensor.index
            if not math.isnan(far[i]):
                memory[start + i] = memory[start + i] + 1.0 if i in outliers else 0.0

    def values(self, memory: Numbers) -> list[list[float]]:
        """Return `MEASURES` of each sensor, (n_sensors, 4); zero without a sample."""
        n, at, windows = self.n_sensors, self._start, len(WINDOWS_S)
        values = [[0.0] * len(MEASURES) for _ in range(n)]
        for sensor in self.sensors:
            i = sensor.index
            for w, a in enumerate(sensor.limits.weights):
                mean, squared = at["mean"] + w * self._n_r, 0.0
                for r in sensor.rows:
                    squared += memory[mean + r] * memory[mean + r]
                values[i][w] = squared * (2.0 - a) / a
                values[i][windows + w] = memory[at["energy"] + w * n + i]
        return values

    def scores(self, memory: Numbers) -> list[float]:
        """Return the largest share of its limits that each sensor has, (n_sensors,)."""
        values, scores = self.values(memory), [0.0] * self.n_sensors
        outliers = self._start["outliers"]
        for sensor in self.sensors:
            i = sensor.index
            score = memory[outliers + i] / sensor.limits.outliers
            for value, limit in zip(values[i], sensor.limits.limit, strict=True):
                score = max(score, value / limit)
            scores[i] = score
        return scores

    def forget(self, memory: Array, sensor: int) -> None:
        """Forget a sensor's samples, its repeats aside."""
        view = self.layout.view
        rows = next(each.rows for each in self.sensors if each.index == sensor)
        for block in ("samples", "outliers", "busy"):
            view(memory, block)[sensor] = 0.0
        view(memory, "energy")[:, sensor] = 0.0
        view(memory, "mean")[:, rows.start : rows.stop] = 0.0
