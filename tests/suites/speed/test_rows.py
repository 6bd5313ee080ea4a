"""Rows as they are written, and the verdicts over them."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from models.gaussian import GaussianState
from models.turntable import paper_turntable, turntable_model
from suites.speed.clock import THREAD_CLOCK, Reading, TurnTimes
from suites.speed.contender import BATCH, ONE_PASS, STEP, Entry, RaceOutcome
from suites.speed.contenders import (
    REUSE_CONTENDERS,
    WINDOW_CONTENDERS,
    sample_contenders,
    stream_contenders,
)
from suites.speed.parts import REUSE_PROBLEM, STREAM_PROBLEM
from suites.speed.problems import PROBLEMS, Problem, find_problem
from suites.speed.rows import Quality, Row, row, write_rows
from suites.speed.runner import Racer
from suites.speed.verdicts import (
    LEAST_SHARE,
    NO_RUN,
    ONE_PASS_20,
    PROMISES,
    Key,
    Promise,
    verdicts,
)

COLUMNS = [
    *("problem", "bounds", "contender", "mode", "horizon", "windows"),
    *("median_s", "p99_s", "max_s", "cost", "build_s", "version"),
]
"""As agreed with those who read the file; more columns may follow."""

CPU = {"min_s": 0.9e-3, "cpu_min_s": 0.8e-3, "cpu_median_s": 0.85e-3}
ROW = Row(
    "pen15", False, "a", ONE_PASS, 20, 3, 1e-3, 2e-3, 3e-3, 4.0, 5.0, "1", 6.0, 7.0, 1.0, **CPU
)


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


def test_the_file_is_a_list_of_rows_without_nan(tmp_path: Path) -> None:
    path = tmp_path / "speed.json"
    write_rows([ROW, dataclasses.replace(ROW, cost=None)], path)
    listed = json.loads(path.read_text("utf-8"))
    assert list(listed[0])[: len(COLUMNS)] == COLUMNS
    assert [each["cost"] for each in listed] == [4.0, None]
    assert listed[0]["bounds"] is False
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_rows([dataclasses.replace(ROW, cost=float("nan"))], path)


def timed(key: Key, cpu_min_s: float, core_share: float = 1.0) -> Row:
    """A row whose every other time would give another verdict."""
    return dataclasses.replace(
        ROW,
        problem=key.problem,
        horizon=key.horizon,
        contender=key.contender,
        mode=key.mode,
        bounds=key.bounds,
        median_s=1.0,
        min_s=1.0,
        cpu_min_s=cpu_min_s,
        cpu_median_s=cpu_min_s + 1e-6,
        core_share=core_share,
    )


SLOW = dataclasses.replace(ONE_PASS_20, contender="slow")


def test_a_promise_is_kept_missed_or_without_a_figure() -> None:
    slow = SLOW
    long = dataclasses.replace(ONE_PASS_20, horizon=41)
    rows = [timed(ONE_PASS_20, 2e-6), timed(slow, 1e-4), timed(long, 5e-6)]
    faster = Promise("", ONE_PASS_20, slow, least=50, inverse=True)
    linear = Promise("", long, ONE_PASS_20, least=0.8, most=1.2, per_stage=True)
    alone = Promise("", ONE_PASS_20, most=1e-6)
    missing = Promise("", dataclasses.replace(slow, mode="x"), ONE_PASS_20)
    bounded = Promise("", dataclasses.replace(slow, bounds=True), ONE_PASS_20)
    found = verdicts(rows, [faster, linear, alone, missing, bounded])
    assert [verdict.kept for verdict in found] == [True, False, False, None, None]
    figures = [verdict.figure for verdict in found[:3]]
    assert figures == pytest.approx([50, 1.25, 3e-6])
    assert [verdict.unjudged for verdict in found] == ["", "", "", NO_RUN, NO_RUN]


@pytest.mark.parametrize("shared", [ONE_PASS_20, SLOW])
def test_nothing_is_judged_where_the_core_was_shared(shared: Key) -> None:
    """Not even what the figure would keep: a run on a loaded machine said 422 times, met."""
    faster = Promise("", ONE_PASS_20, SLOW, least=50, inverse=True)
    for share, kept, why in (
        (LEAST_SHARE, True, ""),
        (0.9499, None, "not judged: only 94 % of a core"),
        (0.5, None, "not judged: only 50 % of a core"),
    ):
        rows = [
            timed(key, time_s, share if key == shared else 1.0)
            for key, time_s in ((ONE_PASS_20, 1e-6), (SLOW, 1e-4))
        ]
        (verdict,) = verdicts(rows, [faster])
        assert (verdict.kept, verdict.unjudged) == (kept, why)
        assert verdict.figure == pytest.approx(100)


def test_a_promise_against_an_absent_peer_is_not_judged() -> None:
    faster = Promise("", ONE_PASS_20, SLOW, least=50, inverse=True)
    left_out = {"slow (one pass)": "slow is not installed"}
    (verdict,) = verdicts([timed(ONE_PASS_20, 1e-6)], [faster], left_out)
    assert (verdict.kept, verdict.figure) == (None, None)
    assert verdict.unjudged == "not judged: slow is not installed"


def test_the_suite_has_a_row_for_every_promise() -> None:
    """By name, so that no promise goes without a figure for a slip of the pen."""
    rows = {
        Key(problem.name, problem.horizon, entry.name, entry.mode, problem.bounded)
        for problem in PROBLEMS
        for entry in WINDOW_CONTENDERS
    }
    streams = {
        STREAM_PROBLEM: (*sample_contenders(0.01), *stream_contenders(1)),
        REUSE_PROBLEM: REUSE_CONTENDERS,
    }
    for key, entries in streams.items():
        for entry in entries:
            assert entry.horizon is not None
            rows.add(Key(find_problem(key).name, entry.horizon, entry.name, entry.mode))
    # Compiled calls against compiled calls, Python's against Python's.
    for promise in PROMISES:
        if promise.to is not None and promise.of.mode not in (BATCH, STEP):
            assert ("call" in promise.of.mode) == ("call" in promise.to.mode), promise.text
    keys = [key for promise in PROMISES for key in (promise.of, promise.to) if key]
    assert set(keys) <= rows
    assert any(key.bounds for key in keys)
