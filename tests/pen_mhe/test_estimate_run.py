"""What `estimate` says beside the estimate: errors, consistency, remarks."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from estimation.consistency import nis
from estimation.estimator import run
from estimation.recording import Recording, Truth
from estimation.status import Status
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from pen_mhe.errors import NOT_OBSERVABLE
from pen_mhe.estimate_run import EstimateRun, estimate_recording
from pen_mhe.estimators import create_estimator
from pen_mhe.sensor_verdict import observe
from recordings.simulate_pen import simulate
from recordings.written import WrittenRecording
from suites.consistency.run import CASES, run_case

pytestmark = pytest.mark.usefixtures("interpreted")
SENSORS = ("accel", "gyro")


def estimated(recording: Recording, writing_area: bool = True) -> EstimateRun:
    return estimate_recording(
        WrittenRecording(recording),
        load_pen("reference"),
        estimator="ekf",
        sensors=SENSORS,
        writing_area=writing_area,
    )


def recorded(duration_s: float = 0.5) -> Recording:
    return simulate(load_pen("reference"), SENSORS, motion="handwriting", duration_s=duration_s)


def with_truth(recording: Recording, missing: str) -> Recording:
    """Return the recording with a truth that lacks one state's values."""
    truth = recording.truth
    assert truth is not None
    values = truth.values.copy()
    values[:, truth.names.index(missing)] = np.nan
    return dataclasses.replace(recording, truth=Truth(truth.time_s, truth.names, values))


def test_a_truth_with_gaps_loses_no_run() -> None:
    result = estimated(with_truth(recorded(), "tip_x_m"))
    assert result.nees is None
    assert "tip_mm" not in result.true_rms
    assert isinstance(result.true_rms["elevation_deg"], float)
    assert len(result.history) == 51


def test_errors_that_would_only_show_the_prior_are_no_numbers() -> None:
    result = estimated(recorded(1.0))
    assert result.nees is not None
    assert result.true_rms["tip_mm"] == NOT_OBSERVABLE
    assert result.true_rms["azimuth_deg"] == NOT_OBSERVABLE
    assert isinstance(result.true_rms["elevation_deg"], float)


def test_a_writing_area_is_no_reading() -> None:
    """Neither in the NIS nor where all samples are lost."""
    recording = recorded()
    with_area, without = estimated(recording), estimated(recording, writing_area=False)
    assert with_area.nis is not None
    assert without.nis is not None
    assert with_area.nis.expected == without.nis.expected == 6


def test_lost_samples_are_remarked_with_a_writing_area() -> None:
    pen = load_pen("reference")
    lossy = {
        name: sensor.model_copy(update={"dropout_fraction": 0.5})
        for name, sensor in pen.sensors.items()
    }
    recording = simulate(
        pen.model_copy(update={"sensors": lossy}), SENSORS, motion="turn", duration_s=0.5
    )
    model = pen_model(pen, SENSORS)
    history = run(create_estimator("ekf", model), recording)
    lost = np.all([np.isnan(recording.readings[name]).all(axis=1) for name in SENSORS], axis=0)
    remarked = [Status.NO_READING in status for status in history.status]
    assert 0 < lost.sum() < len(lost)
    np.testing.assert_array_equal(remarked, lost)
    squared, rows = nis(history, model.measured_rows)
    np.testing.assert_array_equal(np.isnan(squared), lost)
    assert rows.max() == 6


def test_a_drawn_truth_without_a_camera_is_judged_without_the_area() -> None:
    """Sensors without a range: drawn from the model, a second's motion ends at 20 rad/s.

    With the gyroscope's range two thirds of its readings are lost, and what is not measured is
    known to so little that no linearisation holds.
    """
    pen = load_pen("dpoint")
    unlimited = {
        "accel": pen.sensors["accel"].model_copy(update={"range_m_s2": None}),
        "gyro": pen.sensors["gyro"].model_copy(update={"range_rad_s": None}),
    }
    pen = pen.model_copy(update={"sensors": unlimited})
    runs = run_case(pen, SENSORS, CASES["settled"], "ekf", range(20))
    assert abs(runs.nees.mean() - runs.n_x) < 3 * np.sqrt(2 * runs.n_x / len(runs.nees))


@pytest.mark.parametrize("pen", ["dpoint", "reference"])
def test_every_bundled_pen_is_observed_by_default(pen: str) -> None:
    config: PenConfig = load_pen(pen)
    found = observe(config, motions=["still"], duration_s=0.2)
    chosen = {name for name, sensor in config.sensors.items() if sensor.rate_hz is not None}
    chosen |= {name for name, sensor in config.sensors.items() if sensor.is_rest}
    assert {sensor.name for sensor in found.model.sensors} == chosen
