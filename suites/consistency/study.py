"""The work behind ``pen-mhe consistency``: NEES and NIS over many runs, in processes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmark.console import console, print_table
from benchmark.runner.kept import Jobs, kept_results
from estimation.output_folder import check_folder
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from pen_mhe.estimators import check_estimator
from recordings.motion_list import DRAWN
from suites.consistency.run import SETTLED_S, ConsistencyRuns, case_named, joined, run_case

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

    def pair(self) -> tuple[str, str]:
        """Return case and estimator."""
        return self.case, self.estimator


def run_consistency(
    output: Path,
    pen: str,
    sensors: Sequence[str] | None,
    cases: Sequence[str],
    estimators: Sequence[str],
    runs: int,
    jobs: int,
) -> None:
    """Run every case with every estimator and print the table.

    Parameters
    ----------
    output : folder that keeps what is finished
    """
    config = load_pen(pen)
    pen_model(config, sensors)
    for estimator in estimators:
        check_estimator(estimator)
    for case in cases:
        case_named(case)
    check_folder(output)
    tasks = [
        ConsistencyTask(
            config, sensors, case, estimator, range(first, min(first + RUNS_PER_TASK, runs))
        )
        for case in cases
        for estimator in estimators
        for first in range(0, runs, RUNS_PER_TASK)
    ]
    found = kept_results(
        "consistency", _run_task, tasks, output, jobs=Jobs(jobs, row=ConsistencyTask.pair)
    )
    by_pair: dict[tuple[str, str], list[ConsistencyRuns]] = {}
    for task, of_task in zip(tasks, found, strict=True):
        by_pair.setdefault(task.pair(), []).append(of_task)
    rows = [_row(*pair, joined(parts)) for pair, parts in by_pair.items()]
    print_table(
        f"{config.name}, {runs} runs each",
        [
            "truth",
            "estimator",
            f"NEES from {SETTLED_S:g} s on: mean of runs",
            "expected",
            "away / standard errors",
            "at the first sample",
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
        f"{runs.first_nees.mean():.4g}",
        f"{np.mean(runs.nis_per_row):.3f}",
    ]
