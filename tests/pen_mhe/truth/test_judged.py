"""Errors against a truth from elsewhere are those against the simulated truth itself."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import pen_mhe as pm
from models.errors import InputError
from pen_mhe.errors import ERROR_COLUMNS, root_mean_square
from pen_mhe.run_result import EstimateRun
from pen_mhe.truth.judged import JudgedByTruth, judged_by
from recordings.truths.columns import TIP
from recordings.truths.read import read_truth
from recordings.truths.track import ANGLES
from tests.pen_mhe.truth.truths import (
    OFFSET_S,
    angles,
    exact,
    marker,
    recording,
    tablet,
    written,
)


@cache
def _run() -> EstimateRun:
    """Return a run beside its own simulated truth, which is said to be on its clock and frame."""
    truth = recording().truth
    return pm.estimate(
        recording(), "reference", estimator="ekf", truth=truth,
        truth_offset_s=0.0, truth_frame="same",
    )  # fmt: skip


def _own(column: str) -> float:
    truth, output = recording().truth, _run().output
    assert truth is not None
    return root_mean_square(output.names, output.errors(truth), ERROR_COLUMNS)[column]


def _judged(table: pd.DataFrame, folder: Path) -> JudgedByTruth:
    track = read_truth(written(table, folder), "reference")
    return judged_by(track, _run().model, _run().output)


def test_an_estimate_is_the_same_with_a_truth_and_without() -> None:
    alone = pm.estimate(recording(), "reference", estimator="ekf").output.to_pandas()
    shown = _run().to_pandas()[list(alone.columns)]
    pd.testing.assert_frame_equal(
        shown.drop(columns="step_time_s"), alone.drop(columns="step_time_s"), check_exact=True
    )


def test_errors_of_the_same_clock_and_frame_are_those_of_the_simulation() -> None:
    truth, run = recording().truth, _run()
    assert truth is not None
    judged = run.judged
    assert judged is not None
    for column in ("tip_mm", "azimuth_deg", "elevation_deg", "spin_deg"):
        assert judged.figures[column].rms == pytest.approx(_own(column), rel=1e-9)
    told = run.output.errors(truth)[:, [run.output.names.index(n) for n in TIP + ANGLES]]
    shown = judged.columns()[[f"{name}_error" for name in TIP + ANGLES]].to_numpy()
    np.testing.assert_allclose(shown, told, atol=1e-9)
    assert any("if it were aligned all the same" in sentence for sentence in judged.said)
    assert judged.nees is not None
    assert judged.nees.expected == pytest.approx(6)
    assert 3 < judged.nees.mean < 9


def test_a_marker_leaves_the_errors_that_alignment_does_not_explain(tmp_path: Path) -> None:
    judged = _judged(marker(), tmp_path)
    for column in ("tip_mm", "azimuth_deg", "elevation_deg", "spin_deg"):
        assert 0.4 * _own(column) < judged.figures[column].rms < 1.3 * _own(column)
    assert any("it covers 66" in sentence for sentence in judged.said)
    table = judged.columns()
    assert table["elevation_rad_true"].notna().mean() == pytest.approx(2 / 3, abs=0.01)
    away = _run().output.column("elevation_rad") - table["elevation_rad_true"]
    np.testing.assert_allclose(away.dropna(), table["elevation_rad_error"].dropna(), atol=1e-12)


def test_a_tablet_judges_x_and_y(tmp_path: Path) -> None:
    judged = _judged(tablet(), tmp_path)
    assert set(judged.figures) == {"tip_xy_mm"}
    assert judged.figures["tip_xy_mm"].rms < 1.0
    assert judged.nees is not None
    assert judged.nees.expected == pytest.approx(2)


def test_elevation_alone_is_all_that_is_judged(tmp_path: Path) -> None:
    judged = _judged(angles()[["time_s", "elevation_deg"]], tmp_path)
    assert set(judged.figures) == {"elevation_deg"}
    assert judged.figures["elevation_deg"].rms == pytest.approx(_own("elevation_deg"), rel=0.25)
    assert list(judged.columns()) == ["elevation_rad_true", "elevation_rad_error"]
    run = replace(_run(), judged=judged)
    assert list(run.to_pandas())[-2:] == ["elevation_rad_true", "elevation_rad_error"]
    (panel,) = (a for a in run.plot().axes if a.get_ylabel().startswith("elevation"))
    assert "truth" in [line.get_label() for line in panel.lines]


def test_what_cannot_be_aligned_is_said_and_has_no_errors(tmp_path: Path) -> None:
    table = angles()
    table.loc[:, table.columns != "time_s"] = 40.0
    judged = _judged(table, tmp_path)
    assert judged.truth is None
    assert not judged.figures
    run = replace(_run(), judged=judged)
    assert any("no errors against it" in sentence for sentence in run.sentences())
    assert not [column for column in run.to_pandas() if column.endswith("_error")]


@pytest.mark.parametrize("name", ["truth.csv", "none.csv"])
def test_a_file_of_something_else_is_refused_before_the_run(tmp_path: Path, name: str) -> None:
    table = pd.DataFrame({"time_s": np.arange(9) * 0.1, "volts": 1.0, "amperes": 2.0})
    written(table, tmp_path)
    with pytest.raises(InputError, match=r"nothing of a pen's motion among|does not exist"):
        pm.estimate(recording(), truth=tmp_path / name)


def test_an_offset_without_a_truth_is_refused() -> None:
    with pytest.raises(InputError, match="without a truth"):
        pm.estimate(recording(), truth_offset_s=1.0)


def test_columns_are_named_in_the_call(tmp_path: Path) -> None:
    """A truth of headers that say nothing is judged by as the file that they were taken from."""
    table = angles()
    path = written(table.rename(columns=dict(zip(table.columns, "tabc", strict=True))), tmp_path)
    part = recording().first(3.0)
    named = {"truth_columns": "time=t;azimuth=a;elevation=b;spin=c"}
    units = dict.fromkeys(("azimuth", "elevation", "spin"), "deg")
    options = {"estimator": "ekf", "truth_offset_s": OFFSET_S, "truth_frame": "same"}
    found = pm.estimate(part, "reference", truth=path, truth_units=units, **named, **options)
    plain = pm.estimate(part, "reference", truth=written(table, tmp_path, "own.csv"), **options)
    assert found.judged is not None
    assert plain.judged is not None
    assert found.judged.figures == plain.judged.figures
    with pytest.raises(InputError, match="columns of the truth given without a truth"):
        pm.estimate(part, "reference", **named)
    with pytest.raises(InputError, match="columns are given for a truth that is no file"):
        pm.estimate(part, "reference", truth=exact(), **named)
