"""What an estimator costs: time and failed steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmark.report.matrix import Matrix
from benchmark.tasks.results import TASK_COLUMNS
from benchmark.tasks.task import OK


@dataclass(frozen=True)
class Cost:
    """An estimator's cost in the cases of the answer.

    Parameters
    ----------
    median_s, p99_s : of a step: medians over the runs
    solved : mean solved fraction of all runs
    runs, broken : number of runs, and of those whose status is not `OK`
    """

    estimator: str
    median_s: float
    p99_s: float
    solved: float
    runs: int
    broken: int


def costs(found: Sequence[Matrix]) -> list[Cost]:
    """Return the cost of every estimator in the cases of some matrices."""
    import pandas as pd  # slow to import, for tables only

    if not found:
        return []
    cases = {(matrix.suite, matrix.case): matrix.rows for matrix in found}
    runs = pd.concat(list(cases.values())).drop_duplicates(list(TASK_COLUMNS))
    names = dict.fromkeys(name for matrix in found for name in matrix.estimators)
    table = []
    for name in names:
        mine = runs[runs["estimator"] == name]
        ran = mine[mine["status"] == OK]
        table.append(
            Cost(
                name,
                float(ran["step_time_median_s"].median()),
                float(ran["step_time_p99_s"].median()),
                float(mine["solved_fraction"].mean()),
                len(mine),
                len(mine) - len(ran),
            )
        )
    return table
