"""What was promised, as ratios of rows of one run.

Ratios are of CPU times, the least of one row against the least of the other, compiled calls
against compiled calls and calls from Python against calls from Python. A run that had to
share its core judges nothing; nor is a promise kept against a peer that did not run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

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

LEAST_SHARE = 0.95
"""Of a core: a race that had less judges nothing."""
NO_RUN = "no figure"
"""Of a promise on a problem that this run left out."""


@dataclass(frozen=True)
class Key:
    """Which row: problem, horizon, contender and mode, with bounds or without."""

    problem: str
    horizon: int
    contender: str
    mode: str
    bounds: bool = False

    @property
    def label(self) -> str:
        """Name and mode, as of an `Entry`."""
        return f"{self.contender} ({self.mode})"


@dataclass(frozen=True)
class Promise:
    """A figure that is a row's median, or the ratio of its minimum to another row's.

    Parameters
    ----------
    text : what is promised
    of, to : the rows; without `to` the figure is the median CPU time itself, in seconds
    least, most : the figure must lie between them
    per_stage : times are divided by the window's number of stages first
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
    """A promise with its figure; None where a row is missing.

    Parameters
    ----------
    unjudged : why nothing is said of the promise; empty where it is judged
    """

    promise: Promise
    figure: float | None
    unjudged: str = ""

    @property
    def kept(self) -> bool | None:
        """Whether the promise is kept; None where that is not judged."""
        if self.figure is None or self.unjudged:
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
        for own, timed, one_pass, converged in (
            (PASS_CALL_20, "compiled call", PASS_CALL, CONVERGED_CALL),
            (ONE_PASS_20, "whole step", ONE_PASS, CONVERGED),
        )
        for contender, mode, least in (
            ("ipopt", converged, 200),
            ("ipopt-exact", converged, 200),
            ("osqp", one_pass, 40),
            ("osqp-tuned", one_pass, 40),
        )
    ),
    *(
        Promise(
            f"{text}, N = {N}, compiled call: at least {least:g} times faster than {contender}",
            Key(problem, N, "mhe-rti", PASS_CALL, bounds),
            Key(problem, N, contender, PASS_CALL, bounds),
            least=least,
            inverse=True,
        )
        for text, problem, N, bounds, least in (
            ("one pass, 15 states", "pen15", 20, False, 5),
            ("one pass, 15 states", "pen15", 100, False, 9),
            ("one pass, 24 states", "pen24", 20, False, 3.8),
            ("one pass, bounded, 15 states", "pen15", 20, True, 9),
        )
        for contender in ("acados", "acados-tuned")
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
            Key(*PEN_20, "ipopt", mode, bounds=True),
            least=25,
            inverse=True,
        )
        for own, timed, mode in (
            (BOUNDED_CALL_20, "compiled call", CONVERGED_CALL),
            (BOUNDED_20, "whole step", CONVERGED),
        )
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


def verdicts(
    rows: Sequence[Row],
    promises: Sequence[Promise] = PROMISES,
    left_out: Mapping[str, str] = MappingProxyType({}),
) -> list[PromiseVerdict]:
    """Hold rows against promises.

    Parameters
    ----------
    left_out : label of a contender that could not be built → why
    """
    found = {Key(r.problem, r.horizon, r.contender, r.mode, r.bounds): r for r in rows}
    return [_verdict(promise, found, left_out) for promise in promises]


def _verdict(
    promise: Promise, rows: Mapping[Key, Row], left_out: Mapping[str, str]
) -> PromiseVerdict:
    keys = [key for key in (promise.of, promise.to) if key is not None]
    missing = [key for key in keys if key not in rows]
    if missing:
        reasons = [left_out[key.label] for key in missing if key.label in left_out]
        return PromiseVerdict(promise, None, f"not judged: {reasons[0]}" if reasons else NO_RUN)
    share = min(rows[key].core_share for key in keys)
    # Rounded down: 94.9 % is not 95 %.
    shared = f"not judged: only {math.floor(100 * share)} % of a core"
    figure = _figure(promise, [rows[key] for key in keys])
    return PromiseVerdict(promise, figure, shared if share < LEAST_SHARE else "")


def _figure(promise: Promise, rows: Sequence[Row]) -> float:
    if len(rows) == 1:
        return rows[0].cpu_median_s
    own, other = (row.cpu_min_s / (row.horizon + 1 if promise.per_stage else 1) for row in rows)
    return other / own if promise.inverse else own / other
