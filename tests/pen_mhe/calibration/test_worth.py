"""What a calibration is worth: the elevation of a pen whose sensors are crooked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pen_mhe as pm
from models.motions import parse_motions
from pen_mhe.calibration.still import calibrate_still

SENSORS = ["accel", "gyro"]
POSES = parse_motions(
    {
        f"{elevation} {spin}": {
            "kind": "minimum_jerk", "description": "still", "time_s": [0.0, 5.0],
            "tip_mm": [[0, 0, 0]] * 2, "angles_deg": [[0.0, elevation, spin]] * 2,
        }
        for elevation in (-75, -40, 0, 40, 75) for spin in (20, 140, 260)
    }
)  # fmt: skip


def crooked(seed: int) -> pm.PenConfig:
    """Return the reference pen with biases as its file expects, 1 % of scale and misalignment."""
    rng, pen = np.random.default_rng(seed), pm.load_pen("reference")
    off = 0.01 * rng.standard_normal((3, 3))
    S = np.eye(3) + (off + off.T) / 2
    tiny = 1e-9
    changes = {
        "accel": {"sensitivity": tuple(map(tuple, S.tolist())), "bias_std_m_s2": tiny,
                  "bias_m_s2": tuple(0.196 * rng.standard_normal(3))},
        "gyro": {"bias_std_rad_s": tiny, "bias_rad_s": tuple(0.0175 * rng.standard_normal(3))},
    }  # fmt: skip
    sensors = {
        name: sensor.model_copy(update=changes.get(name, {}))
        for name, sensor in pen.sensors.items()
    }
    return pen.model_copy(update={"sensors": sensors})


def elevation_error_deg(pen: pm.PenConfig, recording: pm.Recording) -> float:
    """Return the RMS error from the first second on."""
    history = pm.run(pm.create_estimator("ekf", pm.pen_model(pen, SENSORS)), recording)
    late = history.time_s > 1
    assert recording.truth is not None
    true = recording.truth.states(["elevation_rad"], history.time_s)[:, 0]
    error = np.degrees(history.column("elevation_rad") - true)[late]
    return float(np.sqrt(np.mean(error**2)))


@pytest.mark.slow
def test_a_calibrated_pen_is_as_good_as_one_whose_errors_are_known(tmp_path: Path) -> None:
    errors = []
    for seed in range(10):
        true = crooked(seed)
        poses = [
            pm.simulate(true, SENSORS, motion=pose, duration_s=5.0, seed=100 * seed + i)
            for i, pose in enumerate(POSES.values())
        ]
        calibrate_still(poses, "reference").write(tmp_path / "new.toml")
        recording = pm.simulate(true, SENSORS, motion="handwriting", duration_s=6.0, seed=seed)
        pens = (pm.load_pen("reference"), pm.load_pen(tmp_path / "new.toml"), true)
        errors.append([elevation_error_deg(pen, recording) for pen in pens])
    before, calibrated, known = np.median(errors, axis=0)
    assert before > 0.5
    assert calibrated < 1.1 * known < 0.05
