"""``pen-mhe calibrate``: what it writes, what it refuses, and how it ends."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import pen_mhe as pm
from commands.cli import app
from models.bundled import bundled_pens
from pen_mhe.calibration import still
from recordings.formats.tables import recording_to_table, write_table
from tests.pen_mhe.calibration.mounted import mounted
from tests.pen_mhe.calibration.poses import TWENTY, Array, board

Written = Callable[[str, Array], Path]


@pytest.fixture
def pen(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(bundled_pens()["reference"].read_text("utf-8"), "utf-8")
    return path


@pytest.fixture
def written(tmp_path: Path, pen: Path) -> Written:
    """Write a board's recording in some poses."""

    def write(name: str, poses: Array) -> Path:
        recording = board(1, poses, rest_s=2.0).recording
        write_table(recording_to_table(recording, pm.load_pen(pen)), tmp_path / name)
        return tmp_path / name

    return write


def run(*words: object) -> Result:
    return CliRunner().invoke(app, ["calibrate", *map(str, words)], prog_name="pen-mhe")


def test_it_writes_a_pen_file_and_says_how_sure_it_is(
    written: Written, pen: Path, tmp_path: Path
) -> None:
    # Two files, and their noise is not the same.
    files = [written("a.csv", TWENTY[:10]), written("b.parquet", TWENTY[10:])]
    result = run("still", *files, "--pen", pen, "--output", tmp_path / "new.toml")
    assert result.exit_code == 0, result.output
    truth = board(1, TWENTY[:1])
    rows = [
        line.strip("| ").split(" | ")
        for line in result.stdout.splitlines()
        if line.startswith("| ")
    ]
    found = {(row[0], row[1]): (float(row[2]), float(row[3])) for row in rows[2:]}
    for axis, expected in zip("xyz", truth.bias, strict=True):
        value, std = found["accel", f"bias {axis}"]
        assert 0 < abs(value - expected) < 4 * std < 0.01
    assert "20 still stretches of 1.3 to 1.8 s, 20 different poses" in result.stdout
    assert "accel: |f| is off gravity by " in result.stdout
    accel = pm.load_pen(tmp_path / "new.toml").sensors["accel"]
    np.testing.assert_allclose(np.array(accel.sensitivity), truth.S, atol=1e-3)  # type: ignore[attr-defined]
    text = (tmp_path / "new.toml").read_text("utf-8")
    assert f"calibrate still {files[0]} {files[1]} --pen mine.toml" in text


@pytest.mark.parametrize(
    ("poses", "more", "expected"),
    [
        (TWENTY[:4], (), "was still in 4 different poses"),
        (TWENTY[:4], ("--find", "biases"), "did you mean bias?"),
        (TWENTY[:4], ("--sensors", "camera"), "expected one of accel, gyro"),
        (TWENTY[:1], ("--pen", "reference", "--find", "scale"), "expected at least 7"),
    ],
)
def test_it_refuses_in_one_sentence(
    written: Written, pen: Path, tmp_path: Path, poses: Array, more: tuple[str, ...], expected: str
) -> None:
    output = tmp_path / "new.toml"
    result = run("still", written("a.csv", poses), "--pen", pen, "--output", output, *more)
    assert result.exit_code == 2
    assert expected in result.stderr
    assert result.stderr.count("\n") == 1
    assert not output.exists()


def test_without_the_library_noise_alone_is_refused(
    written: Written, pen: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(still, "has_library", lambda: False)
    words = ("still", written("a.csv", TWENTY), "--pen", pen, "--output", tmp_path / "new.toml")
    said = "they need pip install 'pen-mhe[calibrate]'"
    assert f"noise levels are left as they are: {said}" in run(*words).stdout
    result = run(*words, "--find", "noise")
    assert result.exit_code == 2
    assert f"noise: nothing was found, {said}; expected --find bias" in result.stderr


def test_a_hand_that_writes_is_refused(pen: Path, tmp_path: Path) -> None:
    recording = pm.simulate(pen, ["accel", "gyro"], motion="handwriting", duration_s=6.0, seed=1)
    write_table(recording_to_table(recording, pm.load_pen(pen)), tmp_path / "moving.csv")
    result = run("still", tmp_path / "moving.csv", "--pen", pen, "--output", tmp_path / "new.toml")
    assert result.exit_code == 2
    assert "moving.csv is never still" in result.stderr


@pytest.fixture
def dpoint(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(bundled_pens()["dpoint"].read_text("utf-8"), "utf-8")
    return path


@pytest.mark.slow
def test_a_camera_writes_a_pen_file_and_says_how_sure_it_is(dpoint: Path, tmp_path: Path) -> None:
    recording = mounted(3, 20.0).recording
    write_table(recording_to_table(recording, pm.load_pen(dpoint)), tmp_path / "written.csv")
    words = ("camera", tmp_path / "written.csv", "--pen", dpoint)
    result = run(*words, "--output", tmp_path / "new.toml")
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert "| turn x | " in result.stdout
    assert "the camera's stamps are " in result.stdout
    text = (tmp_path / "new.toml").read_text("utf-8")
    assert "# a camera's frames set these numbers" in text
    assert "#   turn x: " in text
    told, was = pm.load_pen(tmp_path / "new.toml"), pm.load_pen(dpoint)
    assert told.level_rad != was.level_rad
    assert "\nlevel_deg = [" in text
    for name in ("accel", "gyro"):
        assert told.sensors[name].sensor_to_body != was.sensors[name].sensor_to_body  # type: ignore[attr-defined]
    assert told.sensors["camera"] == was.sensors["camera"]


def test_a_recording_without_a_camera_is_refused(dpoint: Path, tmp_path: Path) -> None:
    recording = pm.simulate("dpoint", ["accel", "gyro"], duration_s=1.0)
    write_table(recording_to_table(recording, pm.load_pen(dpoint)), tmp_path / "blind.csv")
    words = ("camera", tmp_path / "blind.csv", "--pen", dpoint)
    result = run(*words, "--output", tmp_path / "new.toml")
    assert result.exit_code == 2
    assert "has no pose_camera, expected one to calibrate by" in result.stderr
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "new.toml").exists()


def test_the_pen_file_is_no_output(written: Written, pen: Path) -> None:
    before = pen.read_text("utf-8")
    result = run("still", written("a.csv", TWENTY), "--pen", pen, "--output", pen)
    assert result.exit_code == 2
    assert "is the pen file that is read" in result.stderr
    assert pen.read_text("utf-8") == before


def test_its_commands_are_named_and_helped_with() -> None:
    assert (
        "command stil is unknown, expected one of still, magnetometer, camera; did you mean still?"
        in run("stil").stderr
    )
    assert "still" in run("--help").stdout
    printed = run("still", "--help").stdout
    assert "noise, bias, scale, misalignment" in " ".join(printed.split())
    assert "{finds}" not in printed
