"""The suite ``optimum``: a task is a window, and its seed says which one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from mhe.realtime import Mhe
from suites.optimum.cases import WindowKey, window_bodies, window_key
from suites.optimum.figures import figures
from suites.optimum.quantities import window_outcome
from suites.optimum.reference import LONGEST_LEFT
from suites.optimum.run import COST_LIMIT, NEWEST_LIMIT, SAME_COST, compare
from suites.optimum.tables import tables

NAME = "optimum"


def tasks(scope: Scope) -> Sequence[Task]:
    """Return a task for every seed, those of one model and horizon together."""
    keys = sorted(map(window_key, range(scope.seeds)), key=lambda key: (key.model, key.horizon))
    return [Task(NAME, key.kind, key.model, Mhe.name, key.seed) for key in keys]


def problem(task: Task) -> tuple[str, int]:
    """Return model and horizon of a task, for which solvers are built."""
    return task.sensors, window_key(task.seed).horizon


def run(task: Task, scope: Scope) -> Outcome:
    """Solve a window both ways."""
    model, horizon = problem(task)
    row = compare(WindowKey(task.seed, model, task.case, horizon))
    return window_outcome(row, window_bodies()[model].model.name)


SUITE = Suite(
    name=NAME,
    title="The optimum: whether mhe ends where IPOPT ends",
    summary=(
        "Windows of a seeded table are solved by mhe and by IPOPT (tolerance 1e-10) from the same "
        "prior, readings and start: of all choices of sensors of the free pen and of the "
        "turntable, five of the pen that cannot spin, the pen without a gyroscope, and the "
        "field's own problems with their bounds; plain, with missing rows, fast, and from bad "
        "starts. A seed is a window: with --seeds 1000 there are 1,000. Whether both are in one "
        f"minimum is decided by cost alone: within {SAME_COST:g} of it. There their newest states "
        f"may be {NEWEST_LIMIT:g} of a posterior standard deviation and their costs "
        f"{COST_LIMIT:g}, relative, apart. What IPOPT leaves undone is measured by an exact Newton "
        "step from where it ends, whatever it says itself; where it is longer than "
        f"{LONGEST_LEFT:g} standard deviations, IPOPT goes on with the exact Hessian, and where it "
        "still is, nothing is compared: IPOPT failed. Quantities that are 1 or 0 count windows."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    tables=tables,
    row=problem,
)
