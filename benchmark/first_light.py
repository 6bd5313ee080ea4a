"""The benchmark for now: one simulated motion, every configuration, every estimator."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmark.metrics import (
    ERROR_COLUMNS,
    NOT_OBSERVABLE,
    root_mean_square,
    seen_only,
    state_errors,
)
from benchmark.observe import judge
from benchmark.registry import BENCHMARK_ESTIMATORS, CONFIGURATIONS, create_estimator
from benchmark.simulate import simulate_recording
from estimation.estimate import EstimateHistory
from estimation.estimator import run
from estimation.observability import Verdict
from estimation.recording import Recording, Truth
from models.pen import PenConfig, pen_model
from models.state_space import StateSpaceModel

if TYPE_CHECKING:
    import pandas as pd

SKIPPED_FRACTION = 0.1
"""Part of the run that is left out of the errors: both estimators still settle."""


@dataclass(frozen=True)
class CellKey:
    """Which configuration, by which estimator, with which noise.

    Parameters
    ----------
    configuration : a key of `benchmark.registry.CONFIGURATIONS`
    estimator : one of `benchmark.registry.BENCHMARK_ESTIMATORS`
    seed : of the simulated recording
    """

    configuration: str
    estimator: str
    seed: int


@dataclass(frozen=True, eq=False)
class Cell:
    """One configuration run by one estimator."""

    key: CellKey
    truth: Truth
    history: EstimateHistory
    row: dict[str, object]


def cell_keys(seeds: Iterable[int]) -> list[CellKey]:
    """Return every cell of the benchmark, the slow estimators first."""
    return [
        CellKey(configuration, estimator, seed)
        for estimator in reversed(BENCHMARK_ESTIMATORS)
        for configuration in CONFIGURATIONS
        for seed in seeds
    ]


def run_cell(pen: PenConfig, key: CellKey, motion: str, duration_s: float) -> Cell:
    """Simulate a cell's recording and estimate it.

    One seed gives every configuration the same motion, and each sensor the same noise.
    """
    configuration = CONFIGURATIONS[key.configuration]
    recording = simulate_recording(pen, configuration.sensors, motion, duration_s, key.seed)
    model = pen_model(pen, configuration.sensors)
    history = run(create_estimator(key.estimator, model), recording)
    verdict = judge(model, recording)
    row = table_row(configuration.label, key.estimator, model, recording, history, verdict)
    assert recording.truth is not None
    return Cell(key, recording.truth, history, row)


def table_row(
    label: str,
    estimator: str,
    model: StateSpaceModel,
    recording: Recording,
    history: EstimateHistory,
    verdict: Verdict,
) -> dict[str, object]:
    """Return one row of the table: RMS errors, or `NOT_OBSERVABLE`."""
    assert recording.truth is not None
    errors = state_errors(model, history, recording.truth)
    settled = errors[int(SKIPPED_FRACTION * len(errors)) :]
    rms = root_mean_square(model, settled, ERROR_COLUMNS)
    return {
        "sensors": label,
        "estimator": estimator,
        **seen_only(model, rms, verdict),
        "solved": history.solved_fraction,
        "median_step_ms": float(np.median(history.step_time_s)) * 1e3,
    }


def as_table(cells: Sequence[Cell]) -> pd.DataFrame:
    """Return one row per configuration and estimator: medians over the seeds.

    A quantity that one seed cannot see counts as not observable.
    """
    import pandas as pd  # slow to import, for tables only

    rows = pd.DataFrame([cell.row for cell in cells])
    keys = ["sensors", "estimator"]
    table = rows.groupby(keys, sort=False).agg(_median).reset_index()
    order = {
        (configuration.label, estimator): place
        for place, (configuration, estimator) in enumerate(
            (configuration, estimator)
            for configuration in CONFIGURATIONS.values()
            for estimator in BENCHMARK_ESTIMATORS
        )
    }
    place = table[keys].apply(tuple, axis=1).map(order)
    return table.loc[place.argsort()].reset_index(drop=True)


def _median(values: pd.Series) -> object:
    if (values == NOT_OBSERVABLE).any():
        return NOT_OBSERVABLE
    return float(np.median(values.to_numpy(dtype=float)))
