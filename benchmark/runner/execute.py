"""One task, in whatever process it ends up."""

from __future__ import annotations

import threading

from benchmark.suites import find_suite
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Task, failed

_one_at_a_time = threading.Lock()
"""Estimators are kept between the tasks of a process, and none serves two threads at once."""


def execute(task: Task, scope: Scope) -> Outcome:
    """Run a task; one that breaks off is an outcome too, with its reason."""
    with _one_at_a_time:
        try:
            return find_suite(task.suite).run(task, scope)
        except Exception as error:  # whatever it is, it is this task's row
            reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
            # A file's name may hold what no table can.
            return failed(reason.encode("utf-8", "replace").decode("utf-8"))
