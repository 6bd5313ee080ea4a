"""The real pen: what both estimators reach on its recording, frames at zero delay."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmark.tasks.suite import Scope
from models.errors import InputError
from models.pen_file import load_pen
from pen_mhe.estimate_run import EstimateRun, estimate_recording
from pen_mhe.estimators import settings_read
from recordings.formats.dpoint import CAMERA_FILE, STYLUS_FILE, read_dpoint
from recordings.read import read_written
from recordings.thinning import CameraThinning
from suites.real.cases import BEST, CAUSAL
from suites.real.suite import SUITE as REAL

EKF_LIMIT_MM = 0.17
MHE_MARGIN_MM = 0.003
HORIZON = 20


def estimate(
    folder: Path, estimator: str, rate_hz: float, phase: int, duration_s: float | None = None
) -> EstimateRun:
    pen = load_pen("dpoint")
    return estimate_recording(
        read_written(folder, pen),
        pen,
        estimator=estimator,
        sensors=("accel", "gyro", "camera"),
        settings=settings_read(estimator, {"horizon": HORIZON, "huber": {}}),
        thinning=CameraThinning(rate_hz, phase),
        duration_s=duration_s,
    )


def ink_mm(run: EstimateRun) -> float:
    assert run.ink is not None
    return run.ink.mean_distance_mm


def test_the_reader_keeps_every_row(dpoint_folder: Path) -> None:
    read = read_dpoint(dpoint_folder, 0.045, 0.022)
    stylus = json.loads((dpoint_folder / STYLUS_FILE).read_text())
    camera = json.loads((dpoint_folder / CAMERA_FILE).read_text())
    times, accel = read.recording.sensor("accel")
    assert len(times) == len(stylus)
    np.testing.assert_array_equal(accel[17], stylus[17]["data"]["accel"])
    frame_times, frames = read.recording.sensor("camera")
    assert len(frame_times) == len(camera)
    np.testing.assert_allclose(frames[9, :3], np.ravel(camera[9]["data"]["position"]))
    # A frame's time is its host stamp less the delay, on the stylus' clock.
    offset = np.median([row["t"] - row["data"]["t"] for row in stylus])
    expected = (camera[9]["t"] - offset - stylus[0]["data"]["t"]) * 1e-3 - 0.045
    assert frame_times[9] == pytest.approx(expected, abs=1e-9)


def test_ekf_on_the_whole_recording(dpoint_folder: Path) -> None:
    run = estimate(dpoint_folder, "ekf", 30, 0)
    assert len(run.output) == 4627
    assert ink_mm(run) <= EKF_LIMIT_MM
    assert run.history.solved_fraction == 1.0
    assert run.zero_delay == ("camera",)


@pytest.mark.slow
def test_mhe_on_ten_seconds(dpoint_folder: Path) -> None:
    """At 10 Hz; at 30 and 3 Hz ten seconds say less than the margin, see below for the whole."""
    ekf = estimate(dpoint_folder, "ekf", 10, 0, 10.0)
    mhe = estimate(dpoint_folder, "mhe", 10, 0, 10.0)
    assert mhe.history.solved_fraction >= 0.99
    # By least squares both: a bounded innovation (EKF) is not a bounded residual (MHE), and on
    # these ten seconds the first one is worth 0.006 mm. Over all phases and the whole recording
    # the margin holds with them, below.
    assert ink_mm(mhe) <= ink_mm(ekf) + 1.5 * MHE_MARGIN_MM


@pytest.mark.slow
def test_mhe_over_all_phases(dpoint_folder: Path) -> None:
    """As the suite runs it: nowhere further from the ink than the EKF, and solved."""
    scope = Scope(seeds=40, data=str(dpoint_folder.parent))
    ink: dict[tuple[str, str], list[float]] = {}
    for task in REAL.tasks(scope):
        if task.case in CAUSAL and task.sensors == BEST and task.estimator in ("ekf", "mhe"):
            outcome = REAL.run(task, scope)
            assert outcome.solved_fraction >= 0.99, task.key
            (found,) = [q.bias for q in outcome.quantities if q.name == "ink"]
            ink.setdefault((task.case, task.estimator), []).append(found)
    judged = [case for case in CAUSAL if (case, "mhe") in ink]
    assert len(judged) == 3
    for case in judged:
        assert len(ink[case, "mhe"]) == 30 // CAUSAL[case].rate_hz
        assert np.mean(ink[case, "mhe"]) <= np.mean(ink[case, "ekf"]) + MHE_MARGIN_MM, case
    assert ink["causal, 30 Hz", "ekf"][0] <= EKF_LIMIT_MM


def test_a_broken_scan_is_refused_before_the_run(dpoint_folder: Path, tmp_path: Path) -> None:
    for name in (STYLUS_FILE, CAMERA_FILE):
        (tmp_path / name).symlink_to(dpoint_folder / name)
    (tmp_path / "scan.jpg").write_bytes((dpoint_folder / "scan.jpg").read_bytes()[:1000])
    with pytest.raises(InputError, match=r"scan\.jpg: .* expected an image"):
        read_written(tmp_path, load_pen("dpoint"))


def test_bad_folders(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"stylus_data\.json: No such file.* expected a D-POINT file"
    ):
        read_dpoint(tmp_path, 0.045, 0.022)
    (tmp_path / CAMERA_FILE).write_text("[]")
    (tmp_path / STYLUS_FILE).write_text("[")
    with pytest.raises(InputError, match="expected JSON"):
        read_dpoint(tmp_path, 0.045, 0.022)
    (tmp_path / STYLUS_FILE).write_text('[{"t": 1, "data": {"t": 1, "gyro": [0, 0, 0]}}]')
    with pytest.raises(InputError, match="expected a list of samples, got none"):
        read_dpoint(tmp_path, 0.045, 0.022)
    (tmp_path / CAMERA_FILE).write_text('[{"t": 1}]')
    with pytest.raises(InputError, match=r"row 1 has no number under data\.accel"):
        read_dpoint(tmp_path, 0.045, 0.022)
