"""What the runner costs: tasks that do nothing, and tasks that only take their time.

Run as ``python -m benchmark.runner.overhead``.
"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmark.runner.run import TaskFunction, Workers, run_tasks
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Quantity, Task

TASKS, BUSY_TASKS, BUSY_S = 10_000, 100, 0.1
"""Tasks that do nothing; tasks that keep a core busy, and for how long each."""


def nothing(task: Task, scope: Scope) -> Outcome:
    """Find one figure at once."""
    return Outcome("", (Quantity.single("seed", "", task.seed),), 1, 1.0, 0.0, 0.0)


def busy(task: Task, scope: Scope) -> Outcome:
    """Find one figure after `BUSY_S` of a core's time."""
    end = time.process_time() + BUSY_S
    while time.process_time() < end:
        pass
    return nothing(task, scope)


def seconds(function: TaskFunction, n: int, jobs: int) -> float:
    """Return how long a run of n tasks took, tables included."""
    tasks = [Task("none", "nothing", "none", "none", seed) for seed in range(n)]
    with TemporaryDirectory() as folder:
        start = time.perf_counter()
        run_tasks(
            tasks,
            Scope(),
            Workers(jobs),
            Path(folder),
            lambda _: lambda _: None,
            function,
            lambda task, scope: "",
        )
        return time.perf_counter() - start


def main() -> None:
    """Print overhead, memory and speed-up."""
    for jobs in (1, 2):
        few, many = seconds(nothing, TASKS // 10, jobs), seconds(nothing, TASKS, jobs)
        per_task = (many - few) / (TASKS - TASKS // 10)
        print(f"{jobs} jobs, {TASKS} tasks that do nothing: {1e3 * per_task:.2f} ms a task")
        print(f"largest memory so far: {_largest_mb():.0f} MB")
    one, two = seconds(busy, BUSY_TASKS, 1), seconds(busy, BUSY_TASKS, 2)
    print(f"{BUSY_TASKS} tasks of {BUSY_S:g} s: {one:.1f} s with one job, {two:.1f} s with two")
    print(f"two jobs are {one / two:.2f} times as fast, their start included")


def _largest_mb() -> float:
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / (2**20 if sys.platform == "darwin" else 2**10)


if __name__ == "__main__":
    main()
