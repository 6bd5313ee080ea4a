"""Deadlines are counted as they are."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.tasks.task import OK, Outcome
from estimation.status import Status
from suites.real_time.deadlines import (
    DUE,
    KINDS,
    LATE,
    OVERRUN,
    PREDICTED,
    SOLVED,
    STOPPED,
    StepDeadline,
    counted,
    deadline_race,
)
from suites.real_time.streams import simulated


def figures(outcome: Outcome) -> dict[str, float]:
    return {quantity.name: quantity.bias for quantity in outcome.quantities}


def test_steps_are_counted() -> None:
    took = np.array([0.5, 1.0, 1.5, 3.0]) * 1e-3
    statuses = [Status.PREDICTED, Status.SOLVED, Status.TIME_LIMIT, Status.NO_READING]
    found = counted("a model", 1e-3, took, statuses)
    assert (found.model, found.samples, found.solved_fraction) == ("a model", 4, 0.5)
    assert figures(found) == pytest.approx(
        {LATE: 0.5, PREDICTED: 0.25, STOPPED: 0.25, SOLVED: 0.5, OVERRUN: 2000.0, DUE: 1000.0}
    )
    assert found.step_time_median_s == pytest.approx(1.25e-3)


def test_in_time_there_is_no_overrun() -> None:
    found = figures(counted("", 1.0, np.array([0.5]), [Status.SOLVED]))
    assert (found[LATE], found[OVERRUN]) == (0, 0)


@pytest.mark.parametrize("deadline", [StepDeadline(30, seconds=0.5), StepDeadline(30, medians=1e6)])
def test_every_estimator_steps_with_the_deadline(deadline: StepDeadline) -> None:
    """So long a one that no step is late."""
    found = deadline_race(simulated("turntable", seconds=0.2), deadline)  # ends, and begins again
    assert set(found) == set(KINDS)
    for outcome in found.values():
        told = figures(outcome)
        assert (outcome.status == OK) == (outcome.reason == "")  # whatever else runs here
        assert outcome.samples == 30
        assert told[LATE] == told[OVERRUN] == 0
        assert told[PREDICTED] + told[STOPPED] + told[SOLVED] == pytest.approx(1)
        assert told[DUE] == 5e5 or deadline.medians
