"""Deadlines are counted as they are."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.status import Status
from suites.real_time.deadlines import KINDS, counted, deadline_rows
from suites.real_time.streams import simulated


def test_steps_are_counted() -> None:
    took = np.array([0.5, 1.0, 1.5, 3.0]) * 1e-3
    statuses = [Status.PREDICTED, Status.SOLVED, Status.TIME_LIMIT, Status.NO_READING]
    row = counted("mhe", 1e-3, took, statuses)
    assert (row.steps, row.in_time) == (4, 0.5)
    assert row.worst_overrun_s == pytest.approx(2e-3)
    assert (row.predicted, row.limited, row.solved) == (0.25, 0.25, 0.5)


def test_in_time_there_is_no_overrun() -> None:
    assert counted("mhe", 1.0, np.array([0.5]), [Status.SOLVED]).worst_overrun_s == 0


def test_every_estimator_and_deadline_has_its_row() -> None:
    stream = simulated("turntable", seconds=0.5)
    rows = [row for name in KINDS for row in deadline_rows(name, stream, 120)]
    assert {row.estimator for row in rows} == set(KINDS)
    for row in rows:
        assert row.predicted + row.limited + row.solved == pytest.approx(1)
    assert [row.steps for row in rows] == [120, 12, 12] * 2
