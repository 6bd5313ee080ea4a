"""The optimum by IPOPT beside `mhe`: how far apart, and at what time a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from benchmark.from_mhe import DISTANCE, NEAR, REFERENCE
from benchmark.tasks.task import OK

if TYPE_CHECKING:
    import pandas as pd

OPTIMUM = "The optimum, by IPOPT"
ABOUT_OPTIMUM = (
    f"{REFERENCE} solves every window to convergence; {NEAR} has the same stretch of the same "
    "recordings. Distance: between their newest states, in claimed deviations of the state that is "
    "farthest; its root mean square and its largest over the steps, each the largest of the runs. "
    "IPOPT is slow: it runs on a quarter of the seeds (one of five), on the begin of a recording "
    "where the case's name says so, and on the pen without a gyroscope in the full run only."
)
HEAD = (
    "Case", "Sensors", "Runs", "Steps", f"Step, {NEAR}", f"Step, {REFERENCE}", "Distance, σ",
    "Largest, σ", f"Solved, {REFERENCE}",
)  # fmt: skip


@dataclass(frozen=True)
class Optimum:
    """One choice of sensors of a case.

    Parameters
    ----------
    runs, steps : of IPOPT, and the median number of steps of a run
    near_s, reference_s : of a step: medians over the same runs
    distance, largest : in deviations: the largest RMS over a run, and the largest of all
    solved : mean solved fraction of IPOPT's runs
    """

    case: str
    sensors: str
    runs: int
    steps: int
    near_s: float
    reference_s: float
    distance: float
    largest: float
    solved: float


def optima(rows: pd.DataFrame) -> list[Optimum]:
    """Return a row per case and sensors that IPOPT ran on, in the order of the results."""
    by = ["suite", "case", "sensors"]
    ran = rows[(rows["status"] == OK) & rows["estimator"].isin((NEAR, REFERENCE))]
    reference = ran[(ran["estimator"] == REFERENCE) & (ran["quantity"] == DISTANCE)]
    found = []
    for key, mine in reference.groupby(by, sort=False, observed=True):
        same = (ran[by] == list(key)).all(axis=1) & ran["seed"].isin(mine["seed"])
        near = ran[same & (ran["estimator"] == NEAR)].drop_duplicates("seed")
        found.append(
            Optimum(
                str(key[1]),
                str(key[2]),
                mine["seed"].nunique(),
                int(mine["samples"].median()),
                float(near["step_time_median_s"].median()),
                float(mine["step_time_median_s"].median()),
                float(mine["rmse"].max()),
                float(mine["max_error"].max()),
                float(mine["solved_fraction"].mean()),
            )
        )
    return found
