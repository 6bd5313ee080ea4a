"""A suite of the benchmark: which tasks it has, how to run one, what to show of them."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmark.figures.figure import Figure, Table
from benchmark.tasks.results import Results
from benchmark.tasks.task import Outcome, Task


@dataclass(frozen=True)
class Scope:
    """How much is asked for.

    Parameters
    ----------
    seeds : number of seeds of every case
    data : folder with recordings, as text; None where there is none
    estimators, cases : the only ones that run; None runs all
    pen : pen file of one's own, or the name of a bundled one
    motion : that the pen is simulated along
    recording : path of one of that pen, instead of simulated ones
    """

    seeds: int = 5
    data: str | None = None
    estimators: tuple[str, ...] | None = None
    pen: str | None = None
    motion: str = "handwriting"
    recording: str | None = None
    cases: tuple[str, ...] | None = None

    @property
    def few_seeds(self) -> int:
        """Number of seeds of what is slow: one of five, five of twenty."""
        return max(1, self.seeds // 4)


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
    claims : TOML file of its claims, see `benchmark.verdicts.claims`; None where it has none
    figures, tables : what the report shows of the results
    missing : a line that says what it lacks within a scope; empty where it lacks nothing
    own : what the report must know of a scope beside its tasks, for ``run.json``
    made_of : what else results depend on within a scope: a hash; empty where nothing
    reads : the folder within `Scope.data` that a task reads; empty where it reads none
    row : what tasks have in common for which something is built or simulated
    is_timed : whether its figures are times: its tasks run after all others, one race at a time
    """

    name: str
    title: str
    summary: str
    tasks: Callable[[Scope], Sequence[Task]]
    run: Callable[[Task, Scope], Outcome]
    claims: Path | None
    figures: Callable[[Results], Sequence[Figure]]
    missing: Callable[[Scope], str] = lambda _: ""
    reads: Callable[[Task], str] = lambda _: ""
    own: Callable[[Scope], Mapping[str, Any]] = lambda _: {}
    made_of: Callable[[Scope], str] = lambda _: ""
    tables: Callable[[Results], Sequence[Table]] = lambda _: ()
    row: Callable[[Task], Hashable] = lambda task: (task.case, task.sensors, task.estimator)
    is_timed: bool = False
