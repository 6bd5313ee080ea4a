"""The filters on a stream: filterpy is this EKF, and one call is as good as many."""

from __future__ import annotations

from typing import Any

import pytest

from ekf_baseline.interpreted import FIRST
from suites.speed.contender import BATCH, Entry
from suites.speed.problems import Problem
from suites.speed.races import StreamPlan, race_filters
from suites.speed.rows import Row

PROBLEM, PLAN = Problem("pen15", 20, 1), StreamPlan(samples=5, warm_up=1, runs=2)
LIMIT = {"filterpy": 1e-6}
ONCE = {**FIRST, "FIRST_UPDATES": 1, "SETTLING_UPDATES": 1}
"""First updates that are linearised once, as filterpy's are."""


@pytest.fixture(scope="module")
def raced() -> tuple[tuple[Row, ...], dict[Entry[Any], str]]:
    absent: dict[Entry[Any], str] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("estimation.native.compiler", lambda: None)
        patch.setattr("ekf_baseline.interpreted.FIRST", ONCE)
        return race_filters(PROBLEM, PLAN, absent.setdefault), absent


Raced = tuple[tuple[Row, ...], dict[Entry[Any], str]]


def test_filterpy_is_this_ekf(raced: Raced) -> None:
    rows, absent = raced
    judged = [row for row in rows if row.horizon == 0]
    assert {row.contender for row in judged} >= {"ekf"}
    if not any(entry.name == "filterpy" for entry in absent):
        assert len([row for row in judged if row.contender == "filterpy"]) == 3
    for row in judged:
        assert row.newest_error_max_std is not None
        assert row.newest_error_std is not None
        assert row.newest_error_max_std < LIMIT.get(row.contender, 1e-9), row.contender
        assert row.cost is None
        assert row.solved == 1


def test_times_are_per_sample(raced: Raced) -> None:
    rows, _ = raced
    for row in rows:
        assert row.windows == (PLAN.runs if row.mode == BATCH else PLAN.samples)
        assert 0 < row.median_s <= row.max_s


def test_an_mhe_is_not_judged_by_a_filter(raced: Raced) -> None:
    rows, _ = raced
    smoothed = [row for row in rows if row.contender.startswith("mhe")]
    assert len(smoothed) >= 4
    assert all(row.newest_error_std is None and row.horizon > 0 for row in smoothed)


def test_missing_rows_leave_filterpy_out(interpreted: None) -> None:
    absent: dict[Entry[Any], str] = {}
    rows = race_filters(Problem("pen24", 20, 1), StreamPlan(2, 1, 1), absent.setdefault)
    assert "filterpy" not in {row.contender for row in rows}
    assert any(entry.name == "filterpy" for entry in absent)
