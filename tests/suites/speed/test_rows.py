"""A row says what a contender did in its race."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from models.gaussian import GaussianState
from models.turntable import paper_turntable, turntable_model
from suites.speed.clock import THREAD_CLOCK, Reading, TurnTimes
from suites.speed.contender import ONE_PASS, Entry, RaceOutcome
from suites.speed.problems import Problem
from suites.speed.rows import Quality, row
from suites.speed.runner import Racer


class Nobody:
    version = "nobody 1"


def test_a_row_summarises_a_racer() -> None:
    model = turntable_model(paper_turntable())
    reference = GaussianState(np.array([0.1, 3.1, 0, 0]), np.diag([1e-4, 4e-4, 1, 1]))
    racer = Racer(Entry("a", ONE_PASS, lambda m, i: Nobody()), Nobody(), 0.5)  # type: ignore[arg-type, return-value]
    for time_s, away in ((1.0, 0.01), (2.0, 0.04), (9.0, 0.02)):
        # θ lies beyond the wrap: -3.1 + … is as near to 3.1 as 2π allows.
        newest = reference.mean + np.array([0, away - 2 * np.pi, 0, 0])
        # Three repeats, of which one was interrupted; wall time twice the CPU time.
        repeats = (time_s, 0.5 * time_s, 4.0 * time_s)
        racer.turns.append(TurnTimes(tuple(Reading(each, each / 2) for each in repeats)))
        racer.outcomes.append(RaceOutcome(time_s < 5, newest))
    free = Problem("pen15", 20, 3)
    made = row(racer, free, model, [reference] * 3, lambda i, _: Quality(float(i), 0.1 * i))
    assert (made.median_s, made.max_s, made.cost, made.build_s) == (2.0, 9.0, 1.0, 0.5)
    assert (made.min_s, made.cpu_min_s, made.cpu_median_s) == (0.5, 0.25, 1.0)
    assert (made.clock, made.core_share) == (THREAD_CLOCK, 1.0)
    assert made.p99_s == np.quantile([1.0, 2.0, 9.0], 0.99)
    assert made.newest_error_std == pytest.approx(1.0)
    assert made.newest_error_max_std == pytest.approx(2.0)
    assert made.solved == pytest.approx(2 / 3)
    assert made.version == "nobody 1"
    assert (made.bounds, made.active_rows, made.violation_std) == (False, None, None)
    infinite = row(racer, free, model, [reference] * 3, lambda *_: Quality(np.inf))
    assert infinite.cost is None
    assert row(racer, free, model, [reference] * 3).cost is None

    bounded = dataclasses.replace(free, bounded=True)
    held = row(racer, bounded, model, [reference] * 3, lambda i, _: Quality(float(i), 0.1 * i), 2.5)
    assert (held.bounds, held.active_rows) == (True, 2.5)
    assert held.violation_std == pytest.approx(0.2)  # the largest of 0, 0.1 and 0.2
    assert row(racer, free, model, [reference] * 3, core_share=0.9).core_share == 0.9
