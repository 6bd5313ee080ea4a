"""A run in parts is the run of the whole: its table to the last bit, and all that it says."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from models.errors import InputError
from models.pen_config import PenConfig
from models.pen_file import load_pen
from pen_mhe.estimate_file import estimate_file
from pen_mhe.estimate_run import estimate_recording
from recordings.formats.tables import read_table, recording_to_table, write_table
from recordings.read import read_written
from recordings.simulate_pen import simulate
from recordings.thinning import CameraThinning

pytestmark = pytest.mark.usefixtures("interpreted")
PEN = load_pen("reference")
SENSORS = ("accel", "gyro", "camera")
THINNED = CameraThinning(10.0, 1)
RUNS: Mapping[str, dict[str, Any]] = {
    "filter": {},
    "causal": {"causal": True},
    "thinned": {"thinning": THINNED},
    "first seconds, causal and thinned": {
        "causal": True,
        "thinning": THINNED,
        "duration_s": 0.31,
    },
    "lag": {"estimator": "mhe-rti", "settings": {"horizon": 6, "lag_samples": 4}},
    "causal lag": {
        "estimator": "mhe-rti",
        "causal": True,
        "thinning": THINNED,
        "settings": {"horizon": 9, "lag_samples": 4},
    },
    "sensors": {"sensors": ["accel", "gyro"]},
    "not watched": {"watch": False},
}


@pytest.fixture(scope="module")
def recorded() -> pd.DataFrame:
    """Half a second in which the camera is late, and some readings are later than others."""
    recording = simulate(PEN, SENSORS, motion="handwriting", duration_s=0.5)
    late = recording.arrivals["camera"].copy()
    late[::7] += 0.02
    arrivals = {**recording.arrivals, "camera": late}
    return recording_to_table(dataclasses.replace(recording, arrivals=arrivals), PEN)


def in_parts(monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    monkeypatch.setattr("recordings.formats.table_stream.PART_ROWS", rows)


def without_times(sentences: list[str]) -> list[str]:
    return [sentence for sentence in sentences if not sentence.startswith("step time")]


def assert_same(path: Path, pen: PenConfig, **options: Any) -> None:
    """Compare the run of a file in parts with that of the whole file."""
    options: dict[str, Any] = {"estimator": "ekf", **options}
    output = path.with_name(f"estimate{path.suffix}")
    summary = estimate_file(path, pen, output, **options)
    whole = estimate_recording(read_written(path, pen), pen, **options)
    expected = path.with_name(f"whole{path.suffix}")
    write_table(whole.to_pandas(), expected)
    timed = ["step_time_s"]
    found, table = (read_table(each).drop(columns=timed) for each in (output, expected))
    pd.testing.assert_frame_equal(found, table, check_exact=True)
    assert without_times(summary.sentences()) == without_times(whole.sentences())
    assert summary.size == whole.summary().size
    assert summary.left_out == whole.left_out
    assert summary.true_rms == whole.true_rms
    assert (summary.nis, summary.nees) == (whole.nis, whole.nees)


QUICK = {"first seconds, causal and thinned"}


@pytest.mark.parametrize(
    "run", [run if run in QUICK else pytest.param(run, marks=pytest.mark.slow) for run in RUNS]
)
def test_parts_are_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: pd.DataFrame, run: str
) -> None:
    in_parts(monkeypatch, 16)
    write_table(recorded, tmp_path / "pen.csv")
    assert_same(tmp_path / "pen.csv", PEN, **RUNS[run])


@pytest.mark.slow
@pytest.mark.parametrize("run", RUNS)
def test_single_rows_are_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: pd.DataFrame, run: str
) -> None:
    in_parts(monkeypatch, 1)
    write_table(recorded, tmp_path / "pen.parquet")
    assert_same(tmp_path / "pen.parquet", PEN, **RUNS[run])


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["mhe", "mhe-sparse", "mhe-ipopt"])
def test_every_engine_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: pd.DataFrame, estimator: str
) -> None:
    """An estimator that steps keeps its state from part to part, as one that takes batches."""
    in_parts(monkeypatch, 4)
    write_table(recorded.iloc[:12], tmp_path / "pen.csv")
    assert_same(tmp_path / "pen.csv", PEN, estimator=estimator, settings={"horizon": 3})


@pytest.mark.slow
def test_what_is_flagged_does_not_depend_on_the_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    in_parts(monkeypatch, 37)
    recording = simulate(PEN, SENSORS, motion="handwriting", duration_s=2.0)
    stuck = recording_to_table(recording, PEN)
    accel = [column for column in stuck.columns if column.startswith("accel_")]
    rows = stuck["accel_x_m_s2"].notna() & stuck["time_s"].between(0.8, 1.3)
    stuck.loc[rows, accel] = stuck.loc[rows, accel].iloc[:1].to_numpy()
    write_table(stuck, tmp_path / "pen.csv")
    assert_same(tmp_path / "pen.csv", PEN)
    flagged = pd.read_csv(tmp_path / "estimate.csv")["flagged"].astype(str)
    assert flagged.str.contains("accel").any()


@pytest.mark.slow
def test_a_truth_with_a_gap(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: pd.DataFrame
) -> None:
    in_parts(monkeypatch, 16)
    gapped = recorded.copy()
    gapped.loc[30, "true_tip_x_m"] = np.nan
    write_table(gapped, tmp_path / "pen.csv")
    assert_same(tmp_path / "pen.csv", PEN)


@pytest.mark.slow
def test_a_figure_draws_all_of_a_short_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: pd.DataFrame
) -> None:
    drawn: list[dict[str, Any]] = []
    monkeypatch.setattr("pen_mhe.figures.save", lambda *_: None)
    monkeypatch.setattr(
        "pen_mhe.figures.estimate_figure",
        lambda history, **more: drawn.append({"history": history, **more}),
    )
    in_parts(monkeypatch, 16)
    write_table(recorded, tmp_path / "pen.csv")
    figure = tmp_path / "run.png"
    estimate_file(tmp_path / "pen.csv", PEN, tmp_path / "o.csv", figure=figure, estimator="ekf")
    whole = estimate_recording(read_written(tmp_path / "pen.csv", PEN), PEN, estimator="ekf")
    assert whole.used.truth is not None
    np.testing.assert_array_equal(drawn[0]["history"].mean, whole.output.mean)
    np.testing.assert_array_equal(drawn[0]["truth"].values, whole.used.truth.values)
    assert drawn[0]["samples"] == len(whole.output)


def test_what_is_smoothed_is_limited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: pd.DataFrame
) -> None:
    write_table(recorded, tmp_path / "pen.csv")
    monkeypatch.setenv("PEN_MHE_MOST_SMOOTHED_ROWS", "50")
    with pytest.raises(InputError, match="instants to smooth, which keeps the whole run, expected"):
        estimate_file(tmp_path / "pen.csv", PEN, tmp_path / "o.csv", estimator="ekf", smooth=True)
    assert not (tmp_path / "o.csv").exists()


def test_readings_that_never_arrive_are_limited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: pd.DataFrame
) -> None:
    in_parts(monkeypatch, 16)
    monkeypatch.setenv("PEN_MHE_MOST_WAITING_ROWS", "5")
    late = recorded.assign(camera_arrival_s=recorded["camera_arrival_s"] + 1e6)
    write_table(late, tmp_path / "pen.csv")
    with pytest.raises(InputError, match="readings have not arrived yet, expected at most 5"):
        estimate_file(tmp_path / "pen.csv", PEN, tmp_path / "o.csv", estimator="ekf", causal=True)
    assert not list(tmp_path.glob("*o.csv*"))
