"""A suite of the benchmark: which tasks it has, how to run one, what to show of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchmark.figures.figure import Figure
from benchmark.tasks.task import Outcome, Task

if TYPE_CHECKING:
    from benchmark.tasks.results import Results


@dataclass(frozen=True)
class Scope:
    """How much is asked for.

    Parameters
    ----------
    seeds : number of seeds of every case
    data : folder with recordings, as text; None where there is none
    estimators : the only ones that run; None runs all
    """

    seeds: int = 5
    data: str | None = None
    estimators: tuple[str, ...] | None = None

    @property
    def few_seeds(self) -> int:
        """Number of seeds of what is slow: one of five, five of twenty."""
        return max(1, self.seeds // 4)


def _nothing(_: object) -> str:
    return ""


@dataclass(frozen=True)
class Suite:
    """A suite.

    Parameters
    ----------
    name : on the command line and in tables
    title : heading of its part of the report
    summary : a paragraph: the question, where it comes from, what was done
    tasks : every task within a scope, the slow ones first
    run : one task
    claims : TOML file of its claims, see `benchmark.verdicts.claims`
    figures : draws the results of the suite
    missing : a line that says what it lacks within a scope; empty where it lacks nothing
    reads : the folder within `Scope.data` that a task reads; empty where it reads none
    """

    name: str
    title: str
    summary: str
    tasks: Callable[[Scope], Sequence[Task]]
    run: Callable[[Task, Scope], Outcome]
    claims: Path
    figures: Callable[[Results], Sequence[Figure]]
    missing: Callable[[Scope], str] = _nothing
    reads: Callable[[Task], str] = _nothing
