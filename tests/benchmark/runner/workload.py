"""Tasks that do little, in a module that other processes find too.

What a task leaves behind goes to the folder `Scope.data`: one file for each time it ran.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmark.runner.single_thread import SINGLE_THREADED
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Quantity, Series, Task

PID = "pid"
DEADLY = 3
"""Seed of the task that kills its process."""


def tasks(n: int) -> list[Task]:
    return [Task("none", f"case {seed % 2}", "none", "nobody", seed) for seed in range(n)]


def figures(task: Task, scope: Scope) -> Outcome:
    """Figures that follow from the seed, a step time that does not."""
    drawn = np.random.default_rng(task.seed).standard_normal(5)
    series = (Series("walk", "mm", np.arange(5.0), drawn.cumsum()),) if task.seed == 0 else ()
    return Outcome(
        "nothing",
        (Quantity.of_errors("walk", "mm", drawn), Quantity.single("last", "s", drawn[-1])),
        len(drawn),
        1.0,
        time.perf_counter(),
        time.perf_counter(),
        series=series,
    )


def figures_noted(task: Task, scope: Scope) -> Outcome:
    """Likewise after 50 ms, leaving a file that says who ran it."""
    assert scope.data is not None
    time.sleep(0.05)
    (Path(scope.data) / f"{task.seed}-{os.getpid()}-{time.monotonic_ns()}").touch()
    return figures(task, scope)


def process_id(task: Task, scope: Scope) -> Outcome:
    """Say which process this is, after 30 ms."""
    time.sleep(0.03)
    return Outcome("", (Quantity.single(PID, "", os.getpid()),), 1, 1.0, 0.0, 0.0)


def deadly(task: Task, scope: Scope) -> Outcome:
    """Kill the process where the seed is `DEADLY`."""
    if task.seed == DEADLY:
        os.kill(os.getpid(), signal.SIGKILL)
    return process_id(task, scope)


def no_identity(task: Task, scope: Scope) -> str:
    return "the same for all"


def times_run(folder: Path) -> dict[int, int]:
    """Return how often each seed ran `figures_noted`."""
    seeds = [int(path.name.split("-")[0]) for path in folder.iterdir()]
    return {seed: seeds.count(seed) for seed in sorted(set(seeds))}


def processes_of(folder: Path) -> set[int]:
    """Return the processes that ran `figures_noted`."""
    return {int(path.name.split("-")[1]) for path in folder.iterdir()}


def pids(outcomes: Sequence[Outcome]) -> set[int]:
    """Return the processes that ran `process_id`."""
    return {int(q.bias) for outcome in outcomes for q in outcome.quantities if q.name == PID}


def threads(task: Task) -> Outcome:
    """What this process' environment says of threads, as the reason."""
    told = {name: os.environ.get(name) for name in SINGLE_THREADED}
    return Outcome("", (), 1, 1.0, 0.0, 0.0, reason=repr(told))
