"""What was promised, as ratios of rows of one run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from suites.speed.contender import (
    BATCH,
    CONVERGED,
    CONVERGED_CALL,
    FULL_STREAM_CALL,
    ONE_PASS,
    OVERHEAD,
    PASS_CALL,
    STEP,
    STREAM_CALL,
)
from suites.speed.rows import Row


@dataclass(frozen=True)
class Key:
    """Which row: problem, horizon, contender and mode, with bounds or without."""

    problem: str
    horizon: int
    contender: str
    mode: str
    bounds: bool = False


@dataclass(frozen=True)
class Promise:
    """A figure that is a row's median, or its ratio to another row's.

    Parameters
    ----------
    text : what is promised
    of, to : the rows; without `to` the figure is the median itself, in seconds
    least, most : the figure must lie between them
    per_stage : medians are divided by the window's number of stages first
    inverse : the figure is shown and judged as to / of: how many times faster
    """

    text: str
    of: Key
    to: Key | None = None
    least: float = 0.0
    most: float = float("inf")
    per_stage: bool = False
    inverse: bool = False


@dataclass(frozen=True)
class PromiseVerdict:
    """A promise with its figure; None where a row is missing."""

    promise: Promise
    figure: float | None

    @property
    def kept(self) -> bool | None:
        """Whether the promise is kept."""
        if self.figure is None:
            return None
        return self.promise.least <= self.figure <= self.promise.most


PEN_20 = ("pen15", 20)
ONE_PASS_20 = Key(*PEN_20, "mhe-rti", ONE_PASS)
PASS_CALL_20 = Key(*PEN_20, "mhe-rti", PASS_CALL)
"""Like the others' times without what surrounds the solver; the whole step holds it."""

BOUNDED_20 = Key(*PEN_20, "mhe", CONVERGED, bounds=True)
BOUNDED_CALL_20 = Key(*PEN_20, "mhe", CONVERGED_CALL, bounds=True)

FILTERPY = Key("pen15", 0, "filterpy", STEP)

PROMISES: tuple[Promise, ...] = (
    *(
        Promise(
            f"one pass, N = 20, {timed}: at least {least} times faster than {contender}",
            own,
            Key(*PEN_20, contender, mode),
            least=least,
            inverse=True,
        )
        for own, timed in ((PASS_CALL_20, "compiled call"), (ONE_PASS_20, "whole step"))
        for contender, mode, least in (
            ("ipopt", CONVERGED, 200),
            ("ipopt-exact", CONVERGED, 200),
            ("osqp", ONE_PASS, 40),
            ("osqp-tuned", ONE_PASS, 40),
        )
    ),
    *(
        Promise(
            f"one pass, compiled call: time per stage at N = {N} against N = 20",
            Key("pen15", N, "mhe-rti", PASS_CALL),
            PASS_CALL_20,
            least=0.8,
            most=1.2,
            per_stage=True,
        )
        for N in (100, 500)
    ),
    *(
        Promise(
            f"bounded, converged, N = 20, {timed}: at least 25 times faster than ipopt",
            own,
            Key(*PEN_20, "ipopt", CONVERGED, bounds=True),
            least=25,
            inverse=True,
        )
        for own, timed in ((BOUNDED_CALL_20, "compiled call"), (BOUNDED_20, "whole step"))
    ),
    Promise(
        "bounded, converged, N = 20, compiled call: against one unbounded pass",
        BOUNDED_CALL_20,
        PASS_CALL_20,
        most=8,
    ),
    *(
        Promise(
            f"one pass along a stream, N = {N}: factors kept against full passes",
            Key("pen24", N, "mhe-rti", STREAM_CALL),
            Key("pen24", N, "mhe-rti", FULL_STREAM_CALL),
            most=most,
        )
        for N, most in ((20, 1 / 2), (100, 1 / 3))
    ),
    Promise(
        "what Python adds to a step of mhe-rti",
        Key(*PEN_20, "mhe-rti", OVERHEAD),
        most=10e-6,
    ),
    *(
        Promise(
            f"EKF {mode}, at least {least} times faster than filterpy with callbacks",
            Key("pen15", 0, "ekf", mode),
            FILTERPY,
            least=least,
            inverse=True,
        )
        for mode, least in ((BATCH, 50), (STEP, 5))
    ),
)
"""What a run of the whole suite is held against."""


def verdicts(rows: Sequence[Row], promises: Sequence[Promise] = PROMISES) -> list[PromiseVerdict]:
    """Hold rows against promises."""
    found = {Key(r.problem, r.horizon, r.contender, r.mode, r.bounds): r for r in rows}
    return [PromiseVerdict(promise, _figure(promise, found)) for promise in promises]


def _figure(promise: Promise, rows: Mapping[Key, Row]) -> float | None:
    times = []
    for key in (promise.of, promise.to):
        if key is None:
            continue
        if key not in rows:
            return None
        stages = key.horizon + 1 if promise.per_stage else 1
        times.append(rows[key].median_s / stages)
    if len(times) == 1:
        return times[0]
    return times[1] / times[0] if promise.inverse else times[0] / times[1]
