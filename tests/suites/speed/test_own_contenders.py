"""The project's own estimators as contenders: a repeated step is a step as it comes live."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from estimation import native
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from models.errors import InputError
from pen_mhe.estimators import ESTIMATORS, EstimatorRow, create_estimator
from suites.speed.contender import STEP, STREAM_CALL, ContenderAbsentError
from suites.speed.contenders import REUSE_CONTENDERS, REUSE_HORIZONS
from suites.speed.exported_contender import ExportedStep
from suites.speed.held_rows import HeldRows
from suites.speed.own_contenders import LiveStep, WindowStep
from suites.speed.problems import Problem
from suites.speed.races import StreamPlan, race_reuse
from suites.speed.samples import filtered_stream
from suites.speed.windows import solved_windows

compiled = pytest.mark.skipif(native.compiler() is None, reason="nothing compiles here")
"""Without a compiler no factors are kept and there is no export."""

TURNTABLE = Problem("turntable", 4, 2)
COUNT = 12


@compiled
def test_a_repeated_window_finds_none_of_its_factors() -> None:
    """Left alone, the second step onto a window would take all factors from the first."""
    (solved,) = solved_windows(TURNTABLE, 1)
    contender = WindowStep(solved.window.model, solved.window, "mhe-rti")
    for _ in range(2):
        contender.prepare(solved.window)
        contender.solve()
        assert contender.estimate.reused_stages == 0
    contender.solve()
    assert contender.estimate.reused_stages == TURNTABLE.horizon


def test_the_state_after_the_window_before_knows_its_active_rows(interpreted: None) -> None:
    problem = Problem("turntable", 20, 1, bounded=True)
    (solved,) = solved_windows(problem, 1)
    window, before = solved.window, solved.window.previous
    contender = WindowStep(window.model, window, "mhe")
    contender.prepare(window)
    marked = contender.layout.view(contender.state.memory, "active")
    held = HeldRows(window.model)
    active = held.active(before.measurements, before.trajectory.states, window.scale)
    np.testing.assert_array_equal(marked, active)
    assert marked.sum() >= 2


@compiled
@pytest.mark.parametrize("threshold", [0.0, 0.5])
def test_a_repeated_step_along_a_stream_keeps_what_it_keeps_live(threshold: float) -> None:
    settings = {"horizon": 5, "reuse_threshold": threshold}
    model = TURNTABLE.model
    stream = filtered_stream(TURNTABLE, model, COUNT)
    live = MheRti(model, MheRtiConfig(**settings))
    state = live.init()
    contender = LiveStep(model, stream.samples[0], "mhe-rti", STEP, settings)
    kept = []
    for sample in stream.samples:
        state, estimate = live.step(state, sample.measurement)
        for _ in range(3):
            contender.prepare(sample)
            contender.solve()
            assert contender.estimate.reused_stages == estimate.reused_stages
            np.testing.assert_array_equal(contender.estimate.state.mean, estimate.state.mean)
        contender.outcome()
        kept.append(estimate.reused_stages)
    assert (max(kept) > 0) == (threshold > 0)


def test_factors_are_kept_by_default_and_by_no_other_entry() -> None:
    keep = [entry for entry in REUSE_CONTENDERS if entry.mode == STREAM_CALL]
    assert tuple(entry.horizon for entry in keep) == REUSE_HORIZONS
    assert len(REUSE_CONTENDERS) == 2 * len(keep)


@compiled
def test_the_reuse_race_has_a_row_per_entry() -> None:
    absent: dict[Any, str] = {}
    rows = race_reuse(TURNTABLE, StreamPlan(3, 1, 1), absent.setdefault)
    assert absent == {}
    expected = [(entry.horizon, entry.mode) for entry in REUSE_CONTENDERS]
    assert [(row.horizon, row.mode) for row in rows] == expected
    assert all(row.windows == 3 and row.median_s > 0 for row in rows)


def test_an_estimator_that_refuses_a_model_is_left_out_with_its_sentence(
    monkeypatch: pytest.MonkeyPatch, interpreted: None
) -> None:
    def refuse(model: Any, settings: Any) -> Any:
        raise InputError("picky does not know this model, expected another")

    table: Mapping[str, Any] = MappingProxyType(
        {**ESTIMATORS, "picky": EstimatorRow(make=refuse, config=MheRtiConfig)}
    )
    monkeypatch.setattr("pen_mhe.estimators.ESTIMATORS", table)
    monkeypatch.setattr("suites.speed.own_contenders.ESTIMATORS", table)
    (solved,) = solved_windows(TURNTABLE, 1)
    with pytest.raises(ContenderAbsentError, match="picky does not know this model"):
        WindowStep(solved.window.model, solved.window, "picky")
    with pytest.raises(ContenderAbsentError, match="not among the estimators"):
        WindowStep(solved.window.model, solved.window, "nobody")


@compiled
@pytest.mark.parametrize(("real", "away_std"), [("double", 1e-9), ("float", 1e-2)])
def test_an_export_is_the_ekf_however_often_a_step_repeats(real: str, away_std: float) -> None:
    model = TURNTABLE.model
    stream = filtered_stream(TURNTABLE, model, COUNT)
    contender = ExportedStep(model, stream.samples[0], "ekf", real)
    ekf = create_estimator("ekf", model)
    state = ekf.init()
    for sample in stream.samples:
        state, estimate = ekf.step(state, sample.measurement)
        for _ in range(2):
            contender.prepare(sample)
            contender.solve()
        found = contender.outcome()
        away = model.difference(found.newest, estimate.state.mean).full().ravel()
        assert np.abs(away / estimate.state.std).max() < away_std
        assert found.solved


def test_there_is_no_export_without_a_compiler(interpreted: None) -> None:
    with pytest.raises(ContenderAbsentError, match="without a compiler"):
        ExportedStep(
            TURNTABLE.model, filtered_stream(TURNTABLE, TURNTABLE.model, 1).samples[0], "ekf"
        )
