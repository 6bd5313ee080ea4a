"""Are answers in time? Steps by the real clock, with deadlines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimation.status import Status
from pen_mhe.estimators import create_estimator
from suites.real_time.streams import Stream

HORIZON = 20
KINDS = ("mhe-rti", "mhe")
SAMPLE_PERIOD_S = 0.01
FACTORS = (2.0, 4.0)
"""Deadlines as multiples of the median step without one, beside the sample period."""
FULL_SHARE = 1.0
SHORT_SHARE = 0.1
"""Of the steps: all with the sample period, few with the others."""


@dataclass(frozen=True)
class DeadlineRow:
    """Many steps with one deadline.

    Parameters
    ----------
    deadline_s : from the beginning of a step
    in_time : share of the steps that took no longer
    worst_overrun_s : how much longer the longest took; 0 where all were in time
    predicted, limited, solved : share of the steps that ended on each rung
    """

    estimator: str
    deadline_s: float
    steps: int
    in_time: float
    worst_overrun_s: float
    predicted: float
    limited: float
    solved: float


def deadline_rows(name: str, stream: Stream, steps: int) -> list[DeadlineRow]:
    """Take so many steps with the sample period, a tenth of them with tighter deadlines.

    Parameters
    ----------
    name : of the estimator, a key of `KINDS`
    """
    median_s = float(np.median(_run(name, stream, None, min(steps, 500))[0]))
    few = max(1, int(SHORT_SHARE * steps))
    plan = [(SAMPLE_PERIOD_S, int(FULL_SHARE * steps))]
    plan += [(factor * median_s, few) for factor in FACTORS]
    return [
        counted(name, deadline_s, *_run(name, stream, deadline_s, count))
        for deadline_s, count in plan
    ]


def counted(
    name: str, deadline_s: float, took_s: np.ndarray, statuses: list[Status]
) -> DeadlineRow:
    """Return the row of steps that took some time and ended in some status."""
    n = len(took_s)
    predicted = sum(Status.PREDICTED in status for status in statuses) / n
    limited = sum(Status.TIME_LIMIT in status for status in statuses) / n
    return DeadlineRow(
        name,
        deadline_s,
        n,
        float(np.mean(took_s <= deadline_s)),
        float(max(0.0, took_s.max() - deadline_s)),
        predicted,
        limited,
        sum(status.is_solved for status in statuses) / n,
    )


def _run(
    name: str, stream: Stream, deadline_s: float | None, count: int
) -> tuple[np.ndarray, list[Status]]:
    """Step through the stream, from its beginning again where it ends: call time and status."""
    estimator = create_estimator(name, stream.model, horizon=HORIZON, deadline_s=deadline_s)
    measurements = list(stream.recording.measurements(stream.model))
    took_s, statuses = np.zeros(count), []
    state = estimator.init()
    for k in range(count):
        measurement = measurements[k % len(measurements)]
        if k % len(measurements) == 0:
            state = estimator.init()
        state, estimate = estimator.step(state, measurement)
        took_s[k] = estimate.call_s
        statuses.append(estimate.status)
    return took_s, statuses
