"""The benchmark for now: one simulated stroke, every configuration, every estimator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchmark.metrics import ERROR_COLUMNS, root_mean_square, state_errors
from benchmark.observe import judge
from benchmark.registry import CONFIGURATIONS, ESTIMATORS, create_estimator
from benchmark.simulate import simulate_recording
from estimation.estimate import EstimateHistory
from estimation.estimator import run
from estimation.observability import Verdict
from estimation.recording import Recording
from models.pen import PenConfig, pen_model
from models.state_space import StateSpaceModel

NOT_OBSERVABLE = "not observable"
SKIPPED_FRACTION = 0.1
"""Part of the run that is left out of the errors: both estimators still settle."""


@dataclass(frozen=True, eq=False)
class Cell:
    """One configuration run by one estimator."""

    configuration: str
    estimator: str
    model: StateSpaceModel
    history: EstimateHistory
    row: dict[str, object]


def run_cells(
    pen: PenConfig,
    stroke_name: str = "turn",
    duration_s: float = 3.0,
    seed: int = 0,
    on_cell: Callable[[Cell], None] | None = None,
) -> tuple[Recording, list[Cell]]:
    """Run every configuration with every estimator on one and the same recording.

    Parameters
    ----------
    on_cell : called with every finished cell
    """
    everything = sorted({name for c in CONFIGURATIONS.values() for name in c.sensors})
    recording = simulate_recording(pen, everything, stroke_name, duration_s, seed)
    cells: list[Cell] = []
    for key, configuration in CONFIGURATIONS.items():
        model = pen_model(pen, configuration.sensors)
        selected = recording.select([sensor.name for sensor in model.measured_sensors])
        verdict = judge(model, selected)
        for estimator in ESTIMATORS:
            history = run(create_estimator(estimator, model), selected)
            row = table_row(configuration.label, estimator, model, selected, history, verdict)
            cells.append(Cell(key, estimator, model, history, row))
            if on_cell:
                on_cell(cells[-1])
    return recording, cells


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
    row: dict[str, object] = {"sensors": label, "estimator": estimator}
    for column, value in root_mean_square(model, settled, ERROR_COLUMNS).items():
        states = [name for name in ERROR_COLUMNS[column][0] if name in model.state_names]
        row[column] = value if all(verdict.sees(name) for name in states) else NOT_OBSERVABLE
    row["solved"] = history.solved_fraction
    row["median_step_ms"] = float(np.median(history.step_time_s)) * 1e3
    return row


def as_table(cells: list[Cell]) -> pd.DataFrame:
    """Return the rows of all cells as a table."""
    return pd.DataFrame([cell.row for cell in cells])
