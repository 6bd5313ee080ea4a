"""The suite ``classics``: problems of the field on every estimator, nothing set but N."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.from_mhe import REFERENCE
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from suites.classics import do_mpc
from suites.classics.figures import UNSCENTED, figures
from suites.classics.problems import PROBLEMS, figures_of
from suites.classics.recordings import SENSOR
from suites.classics.run import run_problem
from suites.peers import installed

NAME = "classics"
ALL_FROM = 100
"""From so many seeds on everything runs on all of them."""


@dataclass(frozen=True)
class ContenderRow:
    """What the suite has to know of a contender.

    Parameters
    ----------
    name : of an estimator, or of one of `PEERS`
    is_slow : whether it runs on a quarter of the seeds, below `ALL_FROM`
    most_samples : of the problems that it then runs on
    package : that it needs; empty for the product's own
    """

    name: str
    is_slow: bool = False
    most_samples: float = math.inf
    package: str = ""

    @property
    def is_there(self) -> bool:
        """Whether it can run here."""
        return not self.package or bool(installed(self.package))

    def seeds(self, case: str, scope: Scope) -> int:
        """Return on how many seeds of a case it runs."""
        if not self.is_slow or scope.seeds >= ALL_FROM:
            return scope.seeds
        return scope.few_seeds if figures_of(case)["samples"] <= self.most_samples else 0


CONTENDERS = (
    ContenderRow(REFERENCE, is_slow=True),
    ContenderRow(do_mpc.NAME, is_slow=True, most_samples=200, package=do_mpc.NAME),
    *map(ContenderRow, (UNSCENTED, *reversed(BENCHMARK_ESTIMATORS))),
)
"""The slow ones first."""


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks, those of the slowest contender first."""
    return [
        Task(NAME, case, SENSOR, row.name, seed)
        for row in CONTENDERS
        if row.is_there
        for case in PROBLEMS
        for seed in range(row.seeds(case, scope))
    ]


def missing(scope: Scope) -> str:
    """Return a line that says who is left out, where somebody is."""
    absent = ", ".join(row.name for row in CONTENDERS if not row.is_there)
    return absent and f"suite {NAME}: {absent} left out, not installed (pip install pen-mhe[peers])"


def made_of(scope: Scope) -> str:
    """Return the versions of what is not the product's."""
    return "-".join(installed(row.package) for row in CONTENDERS if row.package)


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task."""
    return run_problem(task)


SUITE = Suite(
    name=NAME,
    title="Classics: the field's own problems",
    summary=(
        "Problems on which others judge moving-horizon estimation, with their figures: two "
        "reactions of Haseltine and Rawlings (2005), whose priors are wrong by many deviations; "
        "an oscillator of van der Pol whose damping is estimated; do-mpc's rotating masses, one "
        "inertia of which is estimated; acados' pendulum on a cart, whose rod's length is (the "
        "true one does not change, the estimators reckon that it may); CasADi's damped spring, on "
        "which every estimator has to be the Kalman filter; a tank that is read through a "
        "root and nearly empty. All contenders read one file and the same samples; nothing is set "
        "but the horizon N. Truth is drawn with the model's noise; the tank's turns back at its "
        "bound, a disc that turns faster than its own is drawn anew. Bounds are obeyed by the "
        "moving-horizon estimators; Kalman filters have none. "
        "“samples within 3 deviations” is the fraction of the judged samples whose error is at "
        "most three claimed deviations; “run within 3 deviations” is 1 for a run in which the "
        "RMS of that ratio is; “success” is 1 for a run whose RMS error is small enough (of the "
        "spring: that is nowhere farther than 1e-9 from the Kalman filter), else 0. "
        "do-mpc, where it is installed, has its own defaults, weights fixed at the prior's and "
        "no claimed deviation. It and mhe-ipopt run on a quarter of the seeds, do-mpc then not on "
        "the spring and the tank, whose recordings are long (on everything from 100 seeds on)."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    missing=missing,
    made_of=made_of,
    row=lambda task: task.case,
)
