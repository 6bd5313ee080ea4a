"""Fewer frames, and the error against those left out."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.estimator import run
from models.errors import InputError
from models.motion import white_jerk_motion
from models.pen import pen_model
from models.pen_file import load_pen
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate
from recordings.thinning import check_recorded_rate, frames_per_kept, left_out_error


@pytest.mark.parametrize(("rate", "every"), [(30, 1), (15, 2), (10, 3), (3, 10)])
def test_rates_that_divide(rate: float, every: int) -> None:
    assert frames_per_kept(30.0, rate) == every


@pytest.mark.parametrize("rate", [7.0, 0.0, -3.0, 60.0])
def test_rates_that_do_not_divide(rate: float) -> None:
    with pytest.raises(InputError, match="does not divide the recorded 30 Hz"):
        frames_per_kept(30.0, rate)


@pytest.mark.usefixtures("interpreted")
def test_a_camera_at_another_rate_than_its_pen_file_is_refused() -> None:
    pen = load_pen("reference")
    recorded = simulate(pen, ["camera"], motion="turn", duration_s=1.0).subsampled("camera", 2, 0)
    camera = pen_model(pen, ["camera"]).sensor("camera")
    with pytest.raises(InputError, match="camera ran at 15 Hz, expected the pen file's 30 Hz"):
        check_recorded_rate(camera, recorded)


@pytest.mark.usefixtures("interpreted")
def test_left_out_frames_are_judged_by_a_prediction_from_before() -> None:
    """By a pen in plain coordinates, whose prediction is written out here."""
    plain = {"degrees_of_freedom": 5, "motion": white_jerk_motion(10.0, 20.0)}
    pen = load_pen("reference").model_copy(update=plain)
    recorded = simulate(pen, ["accel", "gyro", "camera"], motion="turn", duration_s=1.0, seed=3)
    used = recorded.subsampled("camera", 3, 1)
    model = pen_model(pen, ["accel", "gyro", "camera"])
    history = run(create_estimator("ekf", model), used)
    camera = model.sensor("camera")
    error = left_out_error(model, camera, history, recorded, used)
    assert error is not None
    times, frames = recorded.sensor("camera")
    begins = times[1] + camera.delay_s  # the first that is given arrives
    squares = []
    for index, (time_s, frame) in enumerate(zip(times, frames, strict=True)):
        if index % 3 == 1 or time_s < begins:
            continue
        before = max(k for k, t in enumerate(history.time_s) if t <= time_s)
        x = history.mean[before].copy()
        dt = time_s - history.time_s[before]
        x[:5] += dt * x[5:10] + dt**2 / 2 * x[10:15]
        squares.append(np.asarray(camera.residual(frame, x)).ravel() ** 2)
    assert error.frames == len(squares)
    expected = np.sqrt(np.mean(squares, axis=0)[:3].sum())
    assert error.rms["m"] == pytest.approx(expected, rel=1e-9)
    assert left_out_error(model, camera, history, used, used) is None
