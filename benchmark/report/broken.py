"""Tasks without a full result, with their reasons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from benchmark.tasks.results import TASK_COLUMNS
from benchmark.tasks.task import OK

if TYPE_CHECKING:
    import pandas as pd

MOST = 40
"""Lines of a table; the results have the others."""


@dataclass(frozen=True)
class Broken:
    """Tasks that differ only by their seed and have one status and reason."""

    case: str
    sensors: str
    estimator: str
    status: str
    reason: str
    seeds: tuple[int, ...]


def broken_off(rows: pd.DataFrame) -> Sequence[Broken]:
    """Return the tasks whose status is not `OK`, seeds taken together."""
    tasks = rows[rows["status"] != OK].drop_duplicates(list(TASK_COLUMNS))
    by = ["case", "sensors", "estimator", "status", "reason"]
    groups = tasks.assign(reason=tasks["reason"].fillna("")).groupby(by, sort=False)
    found = []
    for key, part in groups:
        case, sensors, estimator, status, reason = map(str, key)
        seeds = tuple(sorted(int(seed) for seed in part["seed"]))
        found.append(Broken(case, sensors, estimator, status, reason, seeds))
    return found
