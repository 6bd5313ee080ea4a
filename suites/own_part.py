"""A race is run once, and the task of each contender takes its own part of it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from benchmark.tasks.task import Outcome, Task
from models.names import unknown


def part_of(
    task: Task, cases: Collection[str], race: Callable[[], Mapping[str, Outcome]]
) -> Outcome:
    """Return a contender's part of its race.

    Parameters
    ----------
    cases : names of the races
    race : returns what every contender of the task's found

    Raises
    ------
    InputError
        If there is no such race, or no such contender in it.
    """
    if task.case not in cases:
        raise unknown("case", task.case, cases)
    found = race()
    if task.estimator not in found:
        raise unknown("estimator", task.estimator, found)
    return found[task.estimator]
