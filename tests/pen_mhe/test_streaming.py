"""A run in parts is the run of the whole: its table to the last bit, and all that it says."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

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
    options = {"estimator": "ekf", **options}
    output = path.with_name(f"estimate{path.suffix}")
    summary = estimate_file(path, pen, output, **options)
    whole = estimate_recording(read_written(path, pen), pen, **options)
    expected = path.with_name(f"whole{path.suffix}")
    write_table(whole.output.to_pandas(), expected)
    timed = ["step_time_s"]
    found, table = (read_table(each).drop(columns=timed) for each in (output, expected))
    pd.testing.assert_frame_equal(found, table, check_exact=True)
    assert without_times(summary.sentences()) == without_times(whole.sentences())
    assert summary.size == whole.summary().size
    assert summary.left_out == whole.left_out
    assert summary.true_rms == whole.true_rms
    assert (summary.nis, summary.nees) == (whole.nis, whole.nees)


@pytest.mark.parametrize("run", RUNS)
@pytest.mark.parametrize("rows", [1, 16])
def test_parts_are_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: pd.DataFrame, run: str, rows: int
) -> None:
    in_parts(monkeypatch, rows)
    write_table(recorded, tmp_path / "pen.csv")
    assert_same(tmp_path / "pen.csv", PEN, **RUNS[run])
