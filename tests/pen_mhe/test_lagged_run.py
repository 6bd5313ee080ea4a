"""A run at a lag: rows bear the time that they speak of, and everything is judged at that lag."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import pen_mhe as pm
from commands.cli import app
from estimation.recording import Recording
from models.errors import InputError
from pen_mhe.run_result import EstimateRun
from recordings.formats.tables import recording_to_table, write_table

pytestmark = pytest.mark.usefixtures("interpreted")
SENSORS = ["accel", "gyro", "camera"]
LAG, HORIZON = 4, 6


@pytest.fixture(scope="module")
def recording() -> Recording:
    return pm.simulate("reference", SENSORS, motion="handwriting", duration_s=0.3, seed=4)


@pytest.fixture(scope="module")
def runs(recording: Recording) -> dict[int, EstimateRun]:
    settings: dict[str, Any] = {"estimator": "mhe-rti", "horizon": HORIZON}
    return {
        lag: pm.estimate(recording, sensors=SENSORS, lag_samples=lag, **settings)
        for lag in (0, LAG)
    }


def test_rows_speak_of_the_instants_before_the_last(
    recording: Recording, runs: dict[int, EstimateRun]
) -> None:
    samples, instants = recording.sensor("accel")[0], recording.time_s
    lagged = runs[LAG]
    wanted = samples[np.isin(samples, instants[:-LAG])]
    np.testing.assert_array_equal(lagged.output.time_s, wanted)
    assert lagged.rows_without == len(samples) - len(wanted)
    said = " ".join(lagged.sentences())
    assert f"the instant {LAG} samples before the newest that it knows" in said
    assert f"{lagged.rows_without} samples at the end" in said
    assert not any(sentence.startswith("lag") for sentence in runs[0].sentences())
    np.testing.assert_array_equal(lagged.history.mean, runs[0].history.mean)


def test_what_came_later_makes_it_better_and_surer(runs: dict[int, EstimateRun]) -> None:
    plain, lagged = runs[0], runs[LAG]
    at_same = plain.output.at(lagged.output.time_s)
    assert (np.median(lagged.output.std / at_same.std, axis=0) < 1).all()
    assert lagged.true_rms["tip_mm"] < plain.true_rms["tip_mm"]
    assert lagged.nees is not None
    assert plain.nees is not None
    assert lagged.nees.mean != plain.nees.mean


def test_a_recording_that_is_too_short_is_refused(recording: Recording) -> None:
    with pytest.raises(InputError, match="of 3 instants has none that is followed by 4"):
        pm.estimate(
            recording.first(0.0201), sensors=SENSORS[:2], estimator="mhe-rti", lag_samples=4
        )


def test_the_command_writes_rows_of_that_lag(recording: Recording, tmp_path: Path) -> None:
    path, output = tmp_path / "pen.parquet", tmp_path / "out.csv"
    write_table(recording_to_table(recording, pm.load_pen("reference")), path)
    words = ["estimate", str(path), "--pen", "reference", "--output", str(output)]
    words += ["--estimator", "mhe-rti", "--horizon", str(HORIZON), "--lag-samples"]
    done = CliRunner().invoke(app, [*words, str(LAG)])
    assert done.exit_code == 0, done.stderr
    table = pd.read_csv(output).fillna(
        {"flagged": "", "not_observable": ""}
    )  # nothing is an empty cell
    samples = recording.sensor("accel")[0]
    np.testing.assert_allclose(
        table["time_s"], samples[np.isin(samples, recording.time_s[:-LAG])], atol=1e-12
    )
    assert not table.isna().to_numpy().any()
    refused = CliRunner().invoke(app, [*words, str(HORIZON + 1)])
    assert refused.exit_code == 2
    assert "a lag of 7 samples is longer than the window's horizon" in refused.stderr
    assert refused.stderr.count("\n") == 1


def test_the_command_smooths_what_a_filter_said(recording: Recording, tmp_path: Path) -> None:
    path, output = tmp_path / "pen.parquet", tmp_path / "out.csv"
    write_table(recording_to_table(recording, pm.load_pen("reference")), path)
    words = ["estimate", str(path), "--pen", "reference", "--output", str(output), "--smooth"]
    done = CliRunner().invoke(app, [*words, "--estimator", "ekf"])
    assert done.exit_code == 0, done.stderr
    assert "smoothed: each row knows the whole recording" in done.output
    assert len(pd.read_csv(output)) == len(recording.sensor("accel")[0])
    refused = CliRunner().invoke(app, [*words, "--estimator", "mhe"])
    assert refused.exit_code == 2
    assert "mhe is none, expected ekf; others have lag_samples" in refused.stderr
