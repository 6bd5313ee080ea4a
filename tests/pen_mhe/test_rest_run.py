"""`estimate` with a pen that has a sensor of rest, detected or told by the recording."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.recording import Recording
from pen_mhe.estimate_run import EstimateRun, estimate
from recordings.simulate_pen import simulate
from tests.estimation.resting import INERTIAL, inertial, instants, model_at_rest, pen_at_rest

pytestmark = pytest.mark.usefixtures("interpreted")
MODEL = model_at_rest()
TIME_S = instants(1.3)


def recorded(**more: np.ndarray[Any, Any]) -> Recording:
    y = inertial(MODEL, TIME_S, 1)
    return Recording("still", TIME_S, {"accel": y[:, :3], "gyro": y[:, 3:6], **more})


def names(run: EstimateRun) -> list[str]:
    return [sensor.name for sensor in run.model.sensors]


def rested(run: EstimateRun) -> list[int]:
    """Return the steps at which rest was read: the rows of the last sensor."""
    return [int(k) for k in np.flatnonzero(np.isfinite(run.history.innovation[:, -1]))]


def test_rest_is_added_and_found() -> None:
    for sensors in (None, INERTIAL):
        run = estimate(recorded(), pen_at_rest(), sensors=sensors, estimator="ekf")
        assert names(run) == ["accel", "gyro", "area", "still"]
        assert rested(run) == list(range(104, 130))
        assert run.nis is not None
        assert run.nis.expected == 6
        assert set(run.used.readings) == set(INERTIAL)


def test_rest_is_switched_off() -> None:
    told = {"still": np.zeros((len(TIME_S), 3))}
    for recording in (recorded(), recorded(**told)):
        run = estimate(recording, pen_at_rest(), estimator="ekf", rest=False)
        assert names(run) == ["accel", "gyro", "area"]


@pytest.mark.parametrize("sensors", [None, INERTIAL])
def test_what_the_recording_tells_is_not_detected(sensors: tuple[str, ...] | None) -> None:
    told = np.full((len(TIME_S), 3), np.nan)
    told[110:120] = 0
    run = estimate(recorded(still=told), pen_at_rest(), sensors=sensors, estimator="ekf")
    assert [s.name for s in run.model.measured_sensors] == ["accel", "gyro", "still"]
    still = run.model.sensor("still")
    start = sum(s.n_r for s in run.model.sensors[: run.model.sensors.index(still)])
    assert np.flatnonzero(np.isfinite(run.history.innovation[:, start])).tolist() == list(
        range(110, 120)
    )
    assert run.nis is not None
    assert run.nis.expected == 6


def test_a_hand_that_writes_is_not_at_rest() -> None:
    recording = simulate(pen_at_rest(), INERTIAL, motion="handwriting", duration_s=1.3)
    assert rested(estimate(recording, pen_at_rest(), estimator="ekf")) == []
