"""The study of kept factors: against itself nothing is apart, and rows are well-formed."""

from __future__ import annotations

import math

import numpy as np

from estimation.estimator import run
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from mhe.reuse import REUSE_THRESHOLD
from suites.real_time.reuse import (
    FILTERED,
    FULL,
    OTHERS,
    distances,
    interleaved,
    reuse_rows,
)
from suites.real_time.streams import CASES, available, simulated


def test_rows_of_a_short_stream() -> None:
    stream = simulated("turntable", seconds=1.5)
    rows = reuse_rows("turntable", stream, horizons=(5,), thresholds=(0.5, math.inf))
    assert [row.contender for row in rows] == [
        FULL,
        *OTHERS,
        "threshold 0.5",
        "threshold inf",
    ]
    first, *others = rows
    assert (first.rms_std, first.max_std, first.reused, first.time_ratio) == (0, 0, 0, 1)
    for row in others:
        assert 0 < row.rms_std <= row.max_std
        assert row.time_ratio > 0
    assert 0 == others[0].reused < others[2].reused <= others[3].reused < 1


def test_keeping_factors_is_near_full_passes_with_the_same_elimination() -> None:
    rows = reuse_rows(
        "pen24", simulated("pen24", seconds=2.0), horizons=(20,), thresholds=(REUSE_THRESHOLD,)
    )
    of = {row.contender: row for row in rows}
    kept = of[f"threshold {REUSE_THRESHOLD:g}"]
    assert kept.reused > 0.6
    assert 0 < kept.rms_std < 0.004  # as the README says, whatever else is near
    assert kept.rms_std < of[FILTERED].rms_std


def test_taking_turns_changes_nothing() -> None:
    stream = simulated("turntable", seconds=1.3)
    configs = {
        "a": MheRtiConfig(horizon=5, reuse_threshold=0.5),
        "b": MheRtiConfig(horizon=7, reuse_threshold=0.0),
    }
    for name, history in interleaved(stream, configs).items():
        alone = run(MheRti(stream.model, configs[name]), stream.recording)
        np.testing.assert_array_equal(history.mean, alone.mean)
        assert not distances(stream.model, history, alone).any()


def test_without_recordings_the_simulated_streams_are_left() -> None:
    assert set(available(None)) == {name for name, case in CASES.items() if not case.is_real}
