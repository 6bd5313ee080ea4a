"""What a run of the suite is measured by, and runs put together again from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmark.tasks.task import Quantity
from models.arrays import Array
from suites.consistency.run import ConsistencyRuns

if TYPE_CHECKING:
    import pandas as pd

NEES, FIRST_NEES, NIS = "NEES", "NEES at the first sample", "NIS per row"
STATES, STATE_ERROR = "states", "error of a state over its deviation"


def quantities(run: ConsistencyRuns) -> tuple[Quantity, ...]:
    """Return the figures of a single run."""
    figures = {
        NEES: run.nees,
        FIRST_NEES: run.first_nees,
        NIS: run.nis_per_row,
        STATE_ERROR: run.state_error,
        STATES: np.array([run.n_x]),
    }
    return tuple(Quantity.single(name, "1", float(of.item())) for name, of in figures.items())


def runs_of(rows: pd.DataFrame) -> ConsistencyRuns:
    """Return the runs of one cell from its rows of ``results.parquet``."""

    def figures(quantity: str) -> Array:
        return np.asarray(rows[rows["quantity"] == quantity]["bias"], dtype=float)

    return ConsistencyRuns(
        int(figures(STATES)[0]), *map(figures, (NEES, FIRST_NEES, NIS, STATE_ERROR))
    )
