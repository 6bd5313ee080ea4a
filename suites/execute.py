"""Tasks of suites: which there are, how one runs in whatever process it ends up."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Sequence
from pathlib import Path

from benchmark.runner import identity
from benchmark.runner.about import timing_identity
from benchmark.runner.run import TaskFunction, Workers, run_tasks
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Task, failed, reason_of
from models.names import unknown
from suites.table import find_suite

_one_at_a_time = threading.Lock()
"""Estimators are kept between the tasks of a process, and none serves two threads at once."""


def execute(task: Task, scope: Scope) -> Outcome:
    """Run a task; one that breaks off is an outcome too, with its reason."""
    with _one_at_a_time:
        try:
            return find_suite(task.suite).run(task, scope)
        except Exception as error:  # whatever it is, it is this task's row
            return failed(reason_of(error))


def chosen_tasks(suites: Sequence[str], scope: Scope) -> list[Task]:
    """Return the tasks of suites; of one that lacks its data, those that need none.

    Raises
    ------
    InputError
        If an estimator or a case of the scope is in none of the suites.
    """
    tasks = [task for name in suites for task in find_suite(name).tasks(scope)]
    for field, asked in (("estimator", scope.estimators), ("case", scope.cases)):
        if asked is None:
            continue
        known = sorted({getattr(task, field) for task in tasks})
        for name in asked:
            if name not in known:
                raise unknown(field, name, known)
        tasks = [task for task in tasks if getattr(task, field) in asked]
    return tasks


def is_timed(task: Task) -> bool:
    """Return whether a task measures times."""
    return find_suite(task.suite).is_timed


def row_of(task: Task) -> Hashable:
    """Return what a task shares with others for which something is built."""
    return task.suite, find_suite(task.suite).row(task)


def task_identity(task: Task, scope: Scope) -> str:
    """Return what a finished task must have been run with to count as finished."""
    suite = find_suite(task.suite)
    depends_on = timing_identity if suite.is_timed else identity.task_identity
    of_code = depends_on(suite.reads(task), scope)
    own = suite.made_of(scope)
    return f"{of_code}-{own}" if own else of_code


def run_suites(
    tasks: Sequence[Task],
    scope: Scope,
    workers: Workers,
    folder: Path,
    on_start: Callable[[int], Callable[[int], None]],
    function: TaskFunction = execute,
) -> int:
    """Run tasks of suites that are not finished; see `benchmark.runner.run.run_tasks`."""
    return run_tasks(
        tasks,
        scope,
        workers,
        folder,
        on_start,
        function,
        task_identity,
        is_timed=is_timed,
        row=row_of,
    )
