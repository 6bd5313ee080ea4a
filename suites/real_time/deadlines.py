"""Are answers in time? Steps by the real clock, with deadlines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from benchmark.tasks.task import Outcome, Quantity
from estimation.status import Status
from pen_mhe.estimators import create_estimator
from suites.real_time.streams import Stream
from suites.shared_core import CoreClock, judged

HORIZON = 20
KINDS = ("mhe-rti", "mhe")
STEPS, FEW_STEPS = 20_000, 2_000
MEDIAN_STEPS = 500
"""Without a deadline, for the median that one may be a multiple of."""


@dataclass(frozen=True)
class StepDeadline:
    """From the beginning of a step.

    Parameters
    ----------
    steps : that are taken with it
    seconds : its time; None where it is so many `medians` of a step without one
    """

    steps: int
    seconds: float | None = None
    medians: float = 0.0


DEADLINES: Mapping[str, StepDeadline] = MappingProxyType(
    {
        "10-ms": StepDeadline(STEPS, seconds=0.01),
        "2-medians": StepDeadline(FEW_STEPS, medians=2.0),
        "4-medians": StepDeadline(FEW_STEPS, medians=4.0),
    }
)
"""Name → deadline: the sample period, and what is tighter."""

LATE, OVERRUN, DUE = "late steps", "worst overrun", "deadline"
PREDICTED, STOPPED, SOLVED = "predicted", "stopped", "solved"
"""Shares of the steps, beside two times."""


def deadline_race(stream: Stream, deadline: StepDeadline) -> dict[str, Outcome]:
    """Step through a stream with a deadline, one estimator after the other."""
    found = {}
    for name in KINDS:
        seconds = deadline.seconds
        if seconds is None:
            free = _run(name, stream, None, min(deadline.steps, MEDIAN_STEPS))[0]
            seconds = deadline.medians * float(np.median(free))
        took_s, statuses, share = _run(name, stream, seconds, deadline.steps)
        outcome = counted(stream.model.name, seconds, took_s, statuses)
        status, why = judged(share)
        found[name] = replace(outcome, status=status, reason=why)
    return found


def counted(model: str, deadline_s: float, took_s: np.ndarray, statuses: list[Status]) -> Outcome:
    """Return the outcome of steps that took some time and ended in some status."""
    n = len(took_s)
    solved = sum(status.is_solved for status in statuses) / n
    shares = {
        LATE: float(np.mean(took_s > deadline_s)),
        PREDICTED: sum(Status.PREDICTED in status for status in statuses) / n,
        STOPPED: sum(Status.TIME_LIMIT in status for status in statuses) / n,
        SOLVED: solved,
    }
    quantities = (
        *(Quantity.single(name, "1", share) for name, share in shares.items()),
        Quantity.single(OVERRUN, "µs", 1e6 * float(max(0.0, took_s.max() - deadline_s))),
        Quantity.single(DUE, "µs", 1e6 * deadline_s),
    )
    p99 = float(np.quantile(took_s, 0.99))
    return Outcome(model, quantities, n, solved, float(np.median(took_s)), p99)


def _run(
    name: str, stream: Stream, deadline_s: float | None, count: int
) -> tuple[np.ndarray, list[Status], float]:
    """Step through the stream, from its beginning again where it ends.

    Returns
    -------
    Call times and statuses, and what part of a core there was for them
    """
    estimator = create_estimator(name, stream.model, horizon=HORIZON, deadline_s=deadline_s)
    measurements = list(stream.recording.measurements(stream.model))
    took_s, statuses = np.zeros(count), []
    state, clock = estimator.init(), CoreClock()
    for k in range(count):
        measurement = measurements[k % len(measurements)]
        if k % len(measurements) == 0:
            state = estimator.init()
        state, estimate = estimator.step(state, measurement)
        took_s[k] = estimate.call_s
        statuses.append(estimate.status)
    return took_s, statuses, clock.share()
