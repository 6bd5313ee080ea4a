"""A cell of the table: one fault on one estimator with one choice of sensors, over some seeds.

    from suites.faults.cells import run_cell, run_table
    from suites.faults.protocol import faults_for
    from suites.faults.table import fault_named

    scores = run_cell("stuck, imu, 1 s", "ekf", "accel+gyro", seeds=range(3))
    watched = run_cell("stuck, imu, 1 s", "ekf", "accel+gyro", range(3), wrap=Watched)
    print([(each.silent_s, each.right_s, each.said) for each in watched])

    table = run_table(["ekf"], SENSORS, range(3), wrap=Watched)  # (fault key, estimator, sensors)
    print(summary(table))

An estimator is built once for its sensors and wrap, and its fault-free runs are made once a seed:
`wrap` has to be the same object from call to call (a class, a function of a module).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from benchmark.tasks.task import reason_of
from estimation.estimator import BatchEstimator, Estimator, run_measurements
from estimation.history import EstimateHistory
from estimation.recording import Measurement
from pen_mhe.estimators import create_estimator
from suites.faults.given_rows import GivenRows
from suites.faults.inject import injected
from suites.faults.protocol import (
    ESTIMATORS,
    faults_for,
    judged_quantities,
    model_of,
    recorded,
    true_motion,
)
from suites.faults.quantities import WITHIN_S
from suites.faults.scoring import FaultScore, RunErrors, broken, score
from suites.faults.table import Fault, fault_named

Wrap = Callable[[Estimator[Any]], Estimator[Any]]
Cell = tuple[str, str, str]
"""Fault's key, estimator, choice of sensors."""


def bare(estimator: Estimator[Any]) -> Estimator[Any]:
    """Return the estimator itself."""
    return estimator


def run_cell(
    fault: str | Fault, estimator: str, sensors: str, seeds: Iterable[int], wrap: Wrap = bare
) -> list[FaultScore]:
    """Return the score of every seed."""
    chosen = fault_named(fault) if isinstance(fault, str) else fault
    bench = bench_of(estimator, sensors, wrap)
    return [bench.score(chosen, seed) for seed in seeds]


def run_table(
    estimators: Iterable[str],
    sensors: Iterable[str],
    seeds: Sequence[int],
    wrap: Wrap = bare,
    chosen: Callable[[Fault], bool] = lambda fault: True,
) -> dict[Cell, list[FaultScore]]:
    """Return the scores of every fault that a choice of sensors can have."""
    return {
        (fault.key, name, choice): run_cell(fault, name, choice, seeds, wrap)
        for name in estimators
        for choice in sensors
        for fault in faults_for(choice)
        if chosen(fault)
    }


def summary(table: Mapping[Cell, Sequence[FaultScore]]) -> dict[str, float]:
    """Return shares of a table, of its runs and of its cells; a cell is its worst seed.

    Right and accurate again are within 2 s, apart for faults that end and faults that stay.
    """
    cells = list(table.values())
    ended = [scores for (key, *_), scores in table.items() if not fault_named(key).stays]
    staying = [scores for (key, *_), scores in table.items() if fault_named(key).stays]
    found: dict[str, float] = {"cells": len(cells)}
    for word, of, holds in (
        ("silent wrong", cells, lambda each: not each.is_silent_wrong),
        ("right again", ended, lambda each: each.right_s <= WITHIN_S),
        ("right again, fault stays", staying, lambda each: each.right_s <= WITHIN_S),
        ("accurate again", ended, lambda each: each.accurate_s <= WITHIN_S),
        ("accurate again, fault stays", staying, lambda each: each.accurate_s <= WITHIN_S),
        ("finite", cells, lambda each: not each.broke and each.is_finite),
    ):
        of_runs = [holds(each) for scores in of for each in scores]
        of_cells = [all(map(holds, scores)) for scores in of]
        for name, values in ((f"{word}, runs", of_runs), (f"{word}, cells", of_cells)):
            share = _share(values)
            found[name] = 1 - share if word == "silent wrong" else share
    return found


def _share(found: Sequence[bool]) -> float:
    return float(np.mean(found)) if found else math.nan


class Bench:
    """An estimator with a choice of sensors, built once, and its fault-free runs."""

    def __init__(self, estimator: str, sensors: str, wrap: Wrap = bare) -> None:
        self.sensors, self.model = sensors, model_of(sensors)
        settings = ESTIMATORS[estimator]
        self.estimator = wrap(create_estimator(estimator, self.model, **settings))
        self.judged = judged_quantities(self.model)
        self._clean: dict[tuple[int, float], RunErrors] = {}
        self._streams: dict[tuple[int, float], GivenRows] = {}

    def score(self, fault: Fault, seed: int) -> FaultScore:
        """Return the score of one run."""
        return self.scored(fault, seed)[0]

    def scored(self, fault: Fault, seed: int) -> tuple[FaultScore, RunErrors | None]:
        """Return the score of one run and its errors; one that broke off has none."""
        clean = self.clean(seed, fault.duration_s)
        try:
            errors = self.errors(fault, seed)
        except Exception as error:  # whatever it is, it is this run's score
            return broken(reason_of(error)), None
        return score(errors, clean, fault), errors

    def clean(self, seed: int, duration_s: float) -> RunErrors:
        """Return the errors of the fault-free run."""
        key = (seed, duration_s)
        if key not in self._clean:
            self._clean[key] = self._errors(self.stream(*key), seed)
        return self._clean[key]

    def errors(self, fault: Fault, seed: int) -> RunErrors:
        """Return the errors of a run with a fault."""
        clean = self.stream(seed, fault.duration_s)
        return self._errors(injected(fault, clean, self.model, seed), seed)

    def stream(self, seed: int, duration_s: float) -> GivenRows:
        """Return the rows of the fault-free recording."""
        key = (seed, duration_s)
        if key not in self._streams:
            self._streams[key] = GivenRows.of(recorded(self.sensors, seed, duration_s))
        return self._streams[key]

    def history(self, stream: GivenRows) -> EstimateHistory:
        """Return what the estimator makes of rows, in compiled batches where it has them."""
        time_s, y = stream.stacked(self.model)
        if isinstance(self.estimator, BatchEstimator):
            return self.estimator.batch(self.estimator.init(), time_s, y)[1]
        rows = (Measurement(float(at), row) for at, row in zip(time_s, y, strict=True))
        return run_measurements(self.estimator, rows)

    def _errors(self, stream: GivenRows, seed: int) -> RunErrors:
        history = self.history(stream)
        return RunErrors.of(history, self.judged, true_motion(seed, history.time_s))


@lru_cache(maxsize=32)
def bench_of(estimator: str, sensors: str, wrap: Wrap = bare) -> Bench:
    """Return the bench of an estimator, the same one at every call."""
    return Bench(estimator, sensors, wrap)
