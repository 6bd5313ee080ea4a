"""The work behind ``pen-mhe consistency``: NEES and NIS over many runs, in processes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmark.console import console, print_table
from benchmark.runner.independent import finished
from models.pen import PenConfig, pen_model
from models.pen_file import load_pen
from pen_mhe.estimators import check_estimator
from recordings.simulate_pen import DRAWN
from suites.consistency.run import ConsistencyRuns, case_named, joined, run_case

RUNS_PER_TASK = 5

LIMIT = 2.6
"""Standard errors within which a mean NEES counts as consistent."""


@dataclass(frozen=True, eq=False)
class ConsistencyTask:
    """A few runs of one case by one estimator."""

    pen: PenConfig
    sensors: Sequence[str] | None
    case: str
    estimator: str
    seeds: range


def run_consistency(
    pen: str,
    sensors: Sequence[str] | None,
    cases: Sequence[str],
    estimators: Sequence[str],
    runs: int,
    jobs: int,
) -> None:
    """Run every case with every estimator and print the table."""
    config = load_pen(pen)
    pen_model(config, sensors)
    for estimator in estimators:
        check_estimator(estimator)
    for case in cases:
        case_named(case)
    tasks = [
        ConsistencyTask(
            config, sensors, case, estimator, range(first, min(first + RUNS_PER_TASK, runs))
        )
        for case in cases
        for estimator in estimators
        for first in range(0, runs, RUNS_PER_TASK)
    ]
    found: dict[tuple[str, str], dict[int, ConsistencyRuns]] = {}
    for task, future in finished("consistency", _run_task, tasks, jobs):
        found.setdefault((task.case, task.estimator), {})[task.seeds[0]] = future.result()
    rows = [
        _row(case, estimator, joined(part for _, part in sorted(found[case, estimator].items())))
        for case in cases
        for estimator in estimators
    ]
    print_table(
        f"{config.name}, {runs} runs each",
        [
            "truth",
            "estimator",
            "NEES: mean of runs",
            "expected",
            "away / standard errors",
            "NIS per row",
        ],
        rows,
    )
    console.print(f"\nconsistent: within {LIMIT:g} standard errors of the number of states")


def _run_task(task: ConsistencyTask) -> ConsistencyRuns:
    return run_case(task.pen, task.sensors, case_named(task.case), task.estimator, task.seeds)


def _row(case: str, estimator: str, runs: ConsistencyRuns) -> list[str]:
    chosen, mean = case_named(case), runs.nees.mean()
    verdict = "not drawn from the model"
    if chosen.motion == DRAWN:
        verdict = "consistent" if abs(runs.deviation) <= LIMIT else "not consistent"
    return [
        chosen.label,
        estimator,
        f"{mean:.4g} (median {np.median(runs.nees):.4g})",
        f"{runs.n_x}",
        f"{runs.deviation:+.1f} ({verdict})",
        f"{np.mean(runs.nis_per_row):.3f}",
    ]
