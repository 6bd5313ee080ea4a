"""What part of a core a measurement had, and what becomes of it."""

from __future__ import annotations

import time

import pytest

from benchmark.tasks.task import OK
from suites.shared_core import SHARED_CORE, CoreClock, judged


def test_who_sleeps_has_no_core(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "perf_counter", iter((10.0, 14.0)).__next__)
    monkeypatch.setattr(time, "process_time", iter((1.0, 2.0)).__next__)
    clock = CoreClock()
    assert clock.share() == 0.25


@pytest.mark.parametrize(
    ("share", "status", "why"),
    [
        (1.0, OK, ""),
        (0.95, OK, ""),
        (0.9499, SHARED_CORE, "only 94 % of a core"),
        (0.5, SHARED_CORE, "only 50 % of a core"),
    ],
)
def test_less_than_a_core_judges_nothing(share: float, status: str, why: str) -> None:
    assert judged(share) == (status, why)
