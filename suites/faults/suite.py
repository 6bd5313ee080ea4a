"""The suite ``faults``: which tasks, and who runs them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from suites.faults.clean import CLEAN
from suites.faults.contenders import CONTENDERS, SEEDS
from suites.faults.figures import figures
from suites.faults.protocol import SENSORS, faults_for
from suites.faults.real import REAL, real_tasks
from suites.faults.run import run_task
from suites.faults.tables import tables

NAME = "faults"
IN_PART = "accel+gyro+camera"
"""The choice of sensors of which a part of the table is shown."""


def is_full(scope: Scope) -> bool:
    """Whether a scope asks for the whole table."""
    return scope.seeds >= SEEDS


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks, the slowest contender's first; below `SEEDS` seeds a part of them."""
    return list(_tasks(scope) if is_full(scope) else _part())


def _tasks(scope: Scope) -> Iterator[Task]:
    for name, contender in CONTENDERS.items():
        if contender.is_judged_clean:
            yield from real_tasks(NAME, name, scope.data)
        seeds = range(min(scope.seeds, contender.most_seeds))
        for sensors in SENSORS:
            cases = [fault.key for fault in faults_for(sensors)]
            cases += CLEAN if contender.is_judged_clean else []
            yield from (Task(NAME, case, sensors, name, seed) for case in cases for seed in seeds)


def _part() -> Iterator[Task]:
    """Yield one seed of the last fault of each row of the table."""
    last = {fault.name: fault for fault in faults_for(IN_PART)}
    cases = [fault.key for fault in last.values()]
    for name, contender in CONTENDERS.items():
        if contender.in_part:
            own = [*cases, *(list(CLEAN) if contender.is_judged_clean else [])]
            yield from (Task(NAME, case, IN_PART, name, 0) for case in own)


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task."""
    return run_task(task, scope.data, is_long=is_full(scope))


SUITE = Suite(
    name=NAME,
    title="Faults: what lies, and who says so",
    summary=(
        "Readings and stamps of a simulated pen in the hand of a writer are broken in the ways of "
        "one table: dropouts, holes in time, stuck readings, spikes, clipping, bias steps, wrong "
        "scales, units, signs and stamps, poses that are far off. Every estimator runs with a "
        "watch around it, as pen-mhe estimate has it; without one (“unwatched”) they stand "
        "beside it. Judged is what the sensors show: the tilt, and with a camera azimuth and tip "
        "too. An answer is wrong where one of these is more than 5 claimed deviations off (1.5 "
        "times the fault-free run's worst, where that is more), and silent where nothing is said "
        "that the fault-free run never says; a silent wrong answer is more than 0.2 s of both. "
        "Right again is the first instant after the fault's end from which at most 5 % of the "
        "next 0.3 s exceed 3 claimed deviations; of a fault that stays, from its begin, and of "
        "all that follows (one instant may be off but not wrong, as at 1 Hz chance has it in 8 % "
        "of the runs). Accurate again: RMS at most 1.5 times the fault-free run's + 0.3° of "
        "the angles, + 0.5 mm of the tip. Quantities that are 1 or 0 are 1 where a run fails. "
        f"From {SEEDS} seeds on the whole table runs (mhe-ipopt with N = 8 on one seed, those "
        "without a watch on three) and a quarter of an hour without a fault per seed and speed; "
        "below, one seed of the last fault of each row, with all sensors, on the EKF."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    reads=lambda task: REAL[task.case].folder if task.case in REAL else "",
    tables=tables,
)
