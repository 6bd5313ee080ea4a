"""Kept factors: against itself nothing is apart, and what is kept is near."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmark.tasks.task import Outcome, Quantity
from estimation.estimator import run
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from mhe.reuse import REUSE_THRESHOLD
from suites.real_time import reuse
from suites.real_time.reuse import (
    FILTERED,
    FULL,
    KEPT,
    NEWEST,
    OTHERS,
    TIME,
    distances,
    interleaved,
    reuse_race,
    threshold_name,
)
from suites.real_time.streams import simulated


def only(monkeypatch: pytest.MonkeyPatch, *thresholds: float) -> None:
    """Let only so many thresholds run beside the full passes."""
    chosen = dict.fromkeys((FULL, *OTHERS), 0.0) | {threshold_name(t): t for t in thresholds}
    monkeypatch.setattr(reuse, "CONTENDERS", chosen)


def quantities(outcome: Outcome) -> dict[str, Quantity]:
    return {quantity.name: quantity for quantity in outcome.quantities}


def test_a_race_over_a_short_stream(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, 0.5, math.inf)
    stream = simulated("turntable", seconds=1.5)
    found = reuse_race(stream, 5)
    assert list(found) == [FULL, *OTHERS, "threshold 0.5", "threshold inf"]
    told = {name: quantities(outcome) for name, outcome in found.items()}
    first = told.pop(FULL)
    assert (first[NEWEST].rmse, first[NEWEST].max_error, first[KEPT].bias) == (0, 0, 0)
    assert first[TIME].bias == 1
    for of_it in told.values():
        assert 0 < of_it[NEWEST].rmse <= of_it[NEWEST].max_error
        assert of_it[TIME].bias > 0
    kept = [told[name][KEPT].bias for name in (FILTERED, "threshold 0.5", "threshold inf")]
    assert 0 == kept[0] < kept[1] <= kept[2] < 1
    assert all(outcome.samples == len(stream.recording.time_s) for outcome in found.values())


def test_keeping_factors_is_near_full_passes_with_the_same_elimination(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    only(monkeypatch, REUSE_THRESHOLD)
    found = reuse_race(simulated("pen24", seconds=2.0), 20)
    kept = quantities(found[threshold_name(REUSE_THRESHOLD)])
    assert kept[KEPT].bias > 0.6
    assert 0 < kept[NEWEST].rmse < 0.004  # as the page says, whatever else is near
    assert kept[NEWEST].rmse < quantities(found[FILTERED])[NEWEST].rmse


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
