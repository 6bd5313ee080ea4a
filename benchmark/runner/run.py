"""A run: every task that is not finished yet, then the tables."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, repeat
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


Race = tuple[Task, ...]
"""Tasks of one suite, case and seed that measure times: against each other, so all or none."""


def run_alone(
    function: Callable[[Task], Outcome], races: Sequence[Race]
) -> Iterator[tuple[Race, Iterable[Outcome]]]:
    """Yield each race with its outcomes: one after the other, in one process without threads."""
    run_race = partial(_outcomes, function)
    if is_single_threaded():
        yield from run_here(run_race, races)
    elif races:
        with single_threaded_children():
            yield from run_in_processes(
                run_race, races, 1, row=lambda race: race, died=lambda why: repeat(failed(why))
            )


def _outcomes(function: Callable[[Task], Outcome], race: Race) -> Iterable[Outcome]:
    return [function(task) for task in race]


def _together(tasks: Iterable[Task], is_timed: Callable[[Task], bool]) -> list[Race]:
    """Return tasks in groups that run as a whole: races, and every other task by itself."""
    groups: dict[Hashable, list[Task]] = {}
    for task in tasks:
        group = (task.suite, task.case, task.seed) if is_timed(task) else task
        groups.setdefault(group, []).append(task)
    return [tuple(group) for group in groups.values()]


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

    Those that measure times run when all others are finished: nothing runs beside them. A race
    of which one is missing runs again as a whole.

    Parameters
    ----------
    tasks : all that are asked for
    folder : of journal and tables; an interrupted run goes on there
    on_start : given the number of tasks to run, returns what to call with the number of
        tasks that have just finished
    function : runs one task
    identity : what a finished task must have been run with to count as finished
    is_timed : whether a task measures times
    row : what tasks have in common for which something is built: they stay with the process
        that built it

    Returns
    -------
    The number of tasks that were run
    """
    made_with = {task: identity(task, scope) for task in tasks}
    with outcome_journal(folder) as journal:
        todo = [
            group
            for group in _together(tasks, is_timed)
            if not all(journal.has(task, made_with[task]) for task in group)
        ]
        total = sum(map(len, todo))
        advance = on_start(total)
        run_one = partial(function, scope=scope)
        quick = [task for (task, *_) in todo if not is_timed(task)]
        alone = (((task,), (outcome,)) for task, outcome in workers.run(run_one, quick, row))
        races = run_alone(run_one, [group for group in todo if is_timed(group[0])])
        for group, outcomes in chain(alone, races):
            with undisturbed():
                found = zip(group, outcomes, strict=False)
                journal.append_together((task, made_with[task], each) for task, each in found)
                advance(len(group))
        write_tables(sorted(tasks), lambda task: journal.read(task, made_with[task]), folder)
    return total
