"""The suite ``real-time``: each race is run once, and each contender's task takes its part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task
from suites.own_part import part_of
from suites.real_time.cases import CASES
from suites.real_time.figures import figures
from suites.real_time.streams import FOLDER, STREAMS, has_recordings
from suites.real_time.tables import tables

NAME = "real-time"


def tasks(scope: Scope) -> Sequence[Task]:
    """Return a task for each contender of each race; without recordings, of simulated streams."""
    there = has_recordings(scope.data)
    return [
        Task(NAME, name, STREAMS[case.stream].sensors, contender, seed)
        for name, case in CASES.items()
        if there or not case.is_real
        for seed in range(scope.seeds)
        for contender in case.contenders
    ]


def run(task: Task, scope: Scope) -> Outcome:
    """Return a contender's part of its race.

    Raises
    ------
    InputError
        If there is no such race, or no such contender in it.
    """
    return part_of(task, CASES, lambda: _raced(task.case, task.seed, scope.data))


@lru_cache(maxsize=1)
def _raced(name: str, seed: int, data: str | None) -> Mapping[str, Outcome]:
    """Return what every contender found, in one race."""
    case = CASES[name]
    stream = STREAMS[case.stream].stream(None if data is None else Path(data), seed)
    return case.race(stream)


def missing(scope: Scope) -> str:
    """Return a line that says what is left out without recordings."""
    if has_recordings(scope.data):
        return ""
    return (
        f"suite {NAME}: real streams left out, they need a folder with {FOLDER}/ (--data FOLDER, "
        "or the variable PEN_MHE_DATA)"
    )


SUITE = Suite(
    name=NAME,
    title="Real time: how little time does a step need?",
    summary=(
        "mhe-rti keeps the factors of stages whose estimate stays within a threshold of where they "
        "were linearised. Here passes with many thresholds run beside full passes of the same "
        "horizon (“pen24_20”: N = 20), by turns of 50 samples, over steady writing, simulated and "
        "real: how far the newest state is from that of full passes, in its standard deviations "
        "σ, and what part of their time a step takes. Without a camera (pen15) the sensors do not "
        "hold all states, and by default nothing is kept. Then steps by the real clock with "
        "a deadline of one sample, and of two and four times a step's median; and the time of "
        "every instant of the D-POINT recording, and of its IMU's samples where frames come at "
        "their capture or as they arrive (N = 26). A seed is a recording where the stream is "
        "simulated, else one more race over the same recording; with a deadline it is 20,000 "
        "steps (2,000 with the tighter ones), with the status “shared core” where there was less "
        "than 95 % of a core: that judges nothing."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    tables=tables,
    missing=missing,
    reads=lambda task: FOLDER if CASES[task.case].is_real else "",
    is_timed=True,
)
