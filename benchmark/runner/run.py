"""A run: every task that is not finished yet, then the tables."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Protocol

from benchmark.runner.cluster import run_on_cluster
from benchmark.runner.interrupts import undisturbed
from benchmark.runner.outcome_lines import outcome_journal
from benchmark.runner.processes import run_here, run_in_processes
from benchmark.runner.single_thread import is_single_threaded, single_threaded_children
from benchmark.runner.tables import write_tables
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Task, failed


class TaskFunction(Protocol):
    """Runs one task; of a module, so that another process finds it."""

    def __call__(self, task: Task, scope: Scope) -> Outcome:
        """Return what the task found."""


@dataclass(frozen=True)
class Workers:
    """Who runs the tasks.

    Parameters
    ----------
    jobs : processes of this machine; 1 runs them in this one
    scheduler : address of a Dask cluster, which runs them instead
    """

    jobs: int = 2
    scheduler: str | None = None

    def __str__(self) -> str:
        return self.scheduler or str(self.jobs)

    def run(
        self,
        function: Callable[[Task], Outcome],
        tasks: Iterable[Task],
        row: Callable[[Task], Hashable],
    ) -> Iterator[tuple[Task, Outcome]]:
        """Yield each task with its outcome, as they finish; see `run_tasks`."""
        if self.scheduler is not None:
            return run_on_cluster(function, tasks, self.scheduler)
        if self.jobs == 1:
            return run_here(function, tasks)
        return run_in_processes(function, tasks, self.jobs, row=row, died=failed)


def run_alone(
    function: Callable[[Task], Outcome], tasks: Sequence[Task]
) -> Iterator[tuple[Task, Outcome]]:
    """Yield each task with its outcome: one after the other, in one process without threads."""
    if is_single_threaded():
        yield from run_here(function, tasks)
    elif tasks:
        with single_threaded_children():
            yield from run_in_processes(function, tasks, 1, row=_row, died=failed)


def _row(task: Task) -> tuple[str, ...]:
    return task.suite, task.case, task.sensors, task.estimator


def run_tasks(
    tasks: Sequence[Task],
    scope: Scope,
    workers: Workers,
    folder: Path,
    on_start: Callable[[int], Callable[[int], None]],
    function: TaskFunction,
    identity: Callable[[Task, Scope], str],
    *,
    is_timed: Callable[[Task], bool] = lambda task: False,
    row: Callable[[Task], Hashable] = _row,
) -> int:
    """Run the tasks that a folder's journal has not, then write the tables of all.

    Those that measure times run when all others are finished: nothing runs beside them.

    Parameters
    ----------
    tasks : all that are asked for
    folder : of journal and tables; an interrupted run goes on there
    on_start : given the number of tasks to run, returns what to call with the number of
        tasks that have just finished
    function : runs one task
    identity : what a finished task must have been run with to count as finished
    is_timed : whether a task measures times
    row : what neighbouring tasks have in common for which something is built: they stay with
        the process that built it

    Returns
    -------
    The number of tasks that were run
    """
    made_with = {task: identity(task, scope) for task in tasks}
    with outcome_journal(folder) as journal:
        todo = [task for task in tasks if not journal.has(task, made_with[task])]
        advance = on_start(len(todo))
        run_one = partial(function, scope=scope)
        quick = [task for task in todo if not is_timed(task)]
        timed = [task for task in todo if is_timed(task)]
        for task, outcome in chain(workers.run(run_one, quick, row), run_alone(run_one, timed)):
            with undisturbed():
                journal.append(task, made_with[task], outcome)
                advance(1)
        write_tables(sorted(tasks), lambda task: journal.read(task, made_with[task]), folder)
    return len(todo)
