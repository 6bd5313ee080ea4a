"""A real pen from accelerometer and gyroscope, beside its camera, which the run does not use."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pen_mhe as pm

pytestmark = pytest.mark.slow


def test_dpoints_camera_is_a_truth_of_its_inertial_sensors(dpoint_folder: Path) -> None:
    run = pm.estimate(
        dpoint_folder, "dpoint", sensors=["accel", "gyro"], estimator="ekf", truth=dpoint_folder
    )
    judged = run.judged
    assert judged is not None
    assert judged.truth is not None
    line = next(sentence for sentence in judged.said if "its clock" in sentence)
    sign, offset = line.partition("its clock ")[2].split()[:2]
    assert float(offset) < 5e-3, sign  # the reader has taken the camera's delay off
    assert judged.figures["elevation_deg"].rms < 1.0
    assert judged.figures["spin_deg"].rms < 2.0
    known = np.isfinite(judged.truth.values).all(axis=1)
    assert known.mean() > 0.95
