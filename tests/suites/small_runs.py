"""Every suite in small, in a process of its own for a test to end: NAME FOLDER."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import typer

from benchmark.runner.run import Workers
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Task
from commands import benchmark_run
from commands.sentences import one_sentence
from suites.table import find_suite

JOBS = 2


@dataclass(frozen=True)
class SmallRun:
    """A run, and what it writes.

    Parameters
    ----------
    run : fills a folder
    tasks : that it has
    reads_data : whether it needs the folder of real recordings
    """

    run: Callable[[Path], None]
    tasks: int
    reads_data: bool = False


def suite(
    name: str,
    tasks: int,
    chosen: Callable[[Task], bool] = lambda task: True,
    data: str | None = None,
    *,
    seeds: int = 2,
) -> SmallRun:
    """The last tasks of a suite; they are the quickest."""

    def run(folder: Path) -> None:
        scope = Scope(seeds, data)
        some = [task for task in find_suite(name).tasks(scope) if chosen(task)][-tasks:]
        benchmark_run.chosen_tasks = lambda suites, scope: some  # type: ignore[assignment]
        benchmark_run.show_report = lambda folder: None  # type: ignore[assignment]
        benchmark_run.run_benchmark([name], folder, scope, Workers(JOBS), "small")

    return SmallRun(run, tasks, data is not None)


def is_ekf(task: Task) -> bool:
    return task.estimator == "ekf"


def small_suites(data: str) -> dict[str, SmallRun]:
    return {
        "pen": suite("pen", 8, is_ekf),
        "tilt": suite("tilt", 60),
        "gyro-free": suite("gyro-free", 40),
        "classics": suite("classics", 8, is_ekf),
        "faults": suite("faults", 8, is_ekf),
        "real": suite("real", 8, is_ekf, data),
        "bad-starts": suite("bad-starts", 8, is_ekf),
        "consistency": suite("consistency", 8, is_ekf),
        "optimum": suite("optimum", 6, seeds=30),
        "printed-cost": suite("printed-cost", 10),
        # Two races of each.
        "real-time": suite("real-time", 22, lambda task: task.case == "turntable_20"),
        "speed": suite("speed", 26, lambda task: task.case.startswith("turntable_20")),
    }


def main() -> None:
    name, folder, data = sys.argv[1:]
    try:
        with one_sentence():
            small_suites(data)[name].run(Path(folder))
    except typer.Exit as ended:
        sys.exit(ended.exit_code)


if __name__ == "__main__":
    main()
