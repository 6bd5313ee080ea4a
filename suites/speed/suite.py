"""The suite ``speed``: each race is run once, and each contender's task takes its part."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task, failed, reason_of
from suites.own_part import part_of
from suites.speed.acados_library import FOLDER
from suites.speed.cases import CASES
from suites.speed.contender import Entry
from suites.speed.figures import figures
from suites.speed.outcomes import outcomes
from suites.speed.tables import tables

NAME = "speed"
SEED = 0
"""Of every problem's recording: a race is run once, over as many windows as there are seeds."""


def tasks(scope: Scope) -> Sequence[Task]:
    """Return a task for each contender of each race."""
    return [
        Task(NAME, case, found.sensors, name, SEED)
        for case, found in CASES.items()
        for name in found.names
    ]


def run(task: Task, scope: Scope) -> Outcome:
    """Return a contender's part of its race.

    Raises
    ------
    InputError
        If there is no such race, or no such contender in it.
    """
    return part_of(task, CASES, lambda: _raced(task.case, scope.seeds, scope.estimators))


@lru_cache(maxsize=1)
def _raced(case: str, windows: int, asked: tuple[str, ...] | None) -> Mapping[str, Outcome]:
    """Return what every contender that is asked for found, in one race."""
    found = CASES[case].with_windows(windows)
    names = [name for name in found.names if asked is None or name in asked]
    left_out: dict[Entry[Any], str] = {}
    try:
        rows = found.race(found.problem, left_out.setdefault, names)
    except Exception as error:  # or every other task would race, to end alike
        return dict.fromkeys(names, failed(reason_of(error)))
    return outcomes(found.problem.model.name, names, rows, left_out)


def made_of(scope: Scope) -> str:
    """Return how many windows are raced, and whose acados."""
    windows = min(scope.seeds, max(found.problem.windows for found in CASES.values()))
    return f"{windows}-windows-{os.environ.get(FOLDER, '')}"


SUITE = Suite(
    name=NAME,
    title="Speed: how fast, against whom?",
    summary=(
        "All contenders solve the same windows of one recording, one after the other in one "
        "process with one thread, so that a busy machine slows all alike; who begins moves on. "
        "“One pass” is a single Gauss-Newton step from the shifted solution of the window before, "
        "“converged” goes on to the optimum; a “compiled call” is the solver's part of it, "
        "without Python. Times are of a window, or of a sample of a stream. “Newest state” is the "
        "distance of the newest state from the optimum that mhe-ipopt finds (on a stream: from "
        "this EKF), in its standard deviations σ, largest component, median over the windows; "
        "“cost” the true cost of what was found, rolled out through the dynamics; "
        "“excess over bounds” the largest in any window. Every problem is there without bounds "
        "and with some that are active. There is a window for every seed, up to 200, 60 with N = "
        "60 and 100, 20 with N = 500: --seeds 200 runs all of it. A race that had less than 95 % "
        "of a core is shown with the status “shared core”, and judges nothing."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    tables=tables,
    made_of=made_of,
    is_timed=True,
)
