"""``estimate`` as readings arrive: one row per IMU sample, as told when that sample came."""

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

SENSORS = ["accel", "gyro", "camera"]
LAG, HORIZON = 4, 8


@pytest.fixture(scope="module")
def recording() -> Recording:
    return pm.simulate("reference", SENSORS, motion="handwriting", duration_s=0.25, seed=4)


def estimated(recording: Recording, **options: Any) -> EstimateRun:
    return pm.estimate(recording, sensors=SENSORS, causal=True, **options)


def test_a_row_is_what_was_known_when_its_sample_came(recording: Recording) -> None:
    run, samples = estimated(recording, estimator="ekf"), recording.sensor("accel")[0]
    np.testing.assert_array_equal(run.output.time_s, samples)
    np.testing.assert_array_equal(run.output.arrival_s, samples)
    assert len(run.history) > len(samples)
    said = " ".join(run.sentences())
    assert "causal: an estimate uses what had arrived, and no more" in said
    assert "readings arrive after their capture (camera 45 ms)" in said
    assert run.zero_delay == ()
    model = pm.pen_model("reference", SENSORS)
    same = pm.run(pm.create_estimator("ekf", model), recording, causal=True).at(samples)
    np.testing.assert_array_equal(run.output.mean, same.mean)


def test_a_run_at_capture_says_zero_delay(recording: Recording) -> None:
    run = pm.estimate(recording, sensors=SENSORS, estimator="ekf")
    assert run.zero_delay == ("camera",)
    assert run.delays_s == pytest.approx({"camera": 0.045}, abs=1e-9)
    assert not run.is_causal
    assert "arrival_s" not in run.output.to_pandas()


def test_a_lag_is_one_of_imu_samples(recording: Recording) -> None:
    """The window holds frames between them too, so that it is asked for several lags."""
    run = estimated(recording, estimator="mhe-rti", horizon=HORIZON, lag_samples=LAG)
    samples = recording.sensor("accel")[0]
    np.testing.assert_array_equal(run.output.time_s, samples[:-LAG])
    np.testing.assert_array_equal(run.output.arrival_s, samples[LAG:])
    assert (run.lag_samples, run.rows_without) == (LAG, LAG)
    assert set(run.history.lagged) == {LAG, LAG + 1, LAG + 2}


def test_what_makes_no_causal_run_is_refused(recording: Recording) -> None:
    with pytest.raises(InputError, match="causal and smooth, expected one: smoothing knows the"):
        estimated(recording, estimator="ekf", smooth=True)
    with pytest.raises(InputError, match="4 samples of accel are up to 6 instants of all sensors"):
        estimated(recording, estimator="mhe-rti", horizon=5, lag_samples=LAG)
    with pytest.raises(InputError, match="of 3 samples of accel has none that is followed by 4"):
        estimated(recording.first(0.0201), estimator="mhe-rti", lag_samples=LAG)
    with pytest.raises(InputError, match="is not read by ekf"):
        estimated(recording, estimator="ekf", lag_samples=LAG)


@pytest.mark.usefixtures("interpreted")
def test_samples_older_than_another_sensors_have_no_row(recording: Recording) -> None:
    """A gyroscope of 100 Hz, 5 ms later than its accelerometer of 50 Hz between its samples."""
    gyro, accel = recording.sensor("gyro"), recording.sensor("accel")
    given = Recording.from_sensors(
        "late gyroscope",
        {"gyro": gyro, "accel": (accel[0][1::2] + 0.002, accel[1][1::2])},
        arrivals={"gyro": gyro[0] + 0.005},
    )
    run = pm.estimate(given, "reference", sensors=SENSORS[:2], estimator="ekf", causal=True)
    wanted = gyro[0][np.isin(gyro[0], run.history.time_s)]
    np.testing.assert_array_equal(run.output.time_s, wanted)
    np.testing.assert_allclose(run.output.arrival_s - wanted, 0.005, rtol=0, atol=1e-9)
    assert 0 < run.rows_without == len(gyro[0]) - len(wanted)
    assert "older than another sensor's when they arrived" in " ".join(run.sentences())


def test_the_command_writes_when_rows_were_told(recording: Recording, tmp_path: Path) -> None:
    path, output = tmp_path / "pen.parquet", tmp_path / "out.csv"
    write_table(recording_to_table(recording, pm.load_pen("reference")), path)
    words = ["estimate", str(path), "--pen", "reference", "--output", str(output), "--causal"]
    words += ["--estimator", "mhe-rti", "--horizon", str(HORIZON)]
    done = CliRunner().invoke(app, [*words, "--lag-samples", str(LAG)])
    assert done.exit_code == 0, done.stderr
    assert "causal: an estimate uses what had arrived" in done.output
    table, samples = pd.read_csv(output), recording.sensor("accel")[0]
    np.testing.assert_allclose(table["time_s"], samples[:-LAG], atol=1e-12)
    np.testing.assert_allclose(table["arrival_s"], samples[LAG:], atol=1e-12)
    refused = CliRunner().invoke(app, [*words, "--smooth"])
    assert refused.exit_code == 2
    assert refused.stderr.count("\n") == 1
