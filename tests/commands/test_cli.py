"""The command line, as its user calls it."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

from commands.cli import app

runner = CliRunner()
pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "pen.parquet"
    arguments = ["simulate", "--output", str(path), "--duration", "1", "--seed", "2"]
    result = runner.invoke(app, [*arguments, "--sensors", "accel,gyro,camera"])
    assert result.exit_code == 0, result.output
    return path


@pytest.mark.parametrize(("estimator", "settings"), [("ekf", ""), ("mhe", "--horizon 5")])
def test_simulate_then_estimate(
    recording: Path, tmp_path: Path, estimator: str, settings: str
) -> None:
    output, figure = tmp_path / "out.parquet", tmp_path / "out.png"
    result = runner.invoke(
        app,
        f"estimate {recording} --pen reference --sensors accel,gyro,camera --estimator {estimator} "
        f"--output {output} --figure {figure} {settings} --camera-rate 10 --camera-phase 1 "
        "--duration 0.6",
    )
    assert result.exit_code == 0, result.output
    table = pd.read_parquet(output)
    assert len(table) == 61  # one row per IMU sample, camera instants left out
    assert {"time_s", "tip_x_m", "tip_x_m_std", "azimuth_rad", "status", "step_time_s"} <= set(
        table.columns
    )
    assert (table["status"] == "solved").all()
    assert figure.stat().st_size > 10_000
    for text in ("61 samples", "solved 100.00%", "step time: median", "zero delay"):
        assert text in result.output
    assert "RMS error against 11 frames left out" in result.output
    assert "RMS error against the truth: tip_mm" in result.output


def test_the_output_is_plain_in_a_pipe(recording: Path, tmp_path: Path) -> None:
    given = f"--pen reference --estimator ekf --output {tmp_path / 'o.csv'}".split()
    result = runner.invoke(app, ["estimate", str(recording), *given])
    assert result.exit_code == 0, result.output
    assert "\x1b" not in result.output
    assert len(pd.read_csv(tmp_path / "o.csv")) == 101


BAD = {
    "unknown sensor": (["--sensors", "accel,radar"], "sensor radar is not in the pen"),
    "sensor without readings": (["--sensors", "accel_lower"], "has no sensor accel_lower"),
    "horizon": (
        ["--estimator", "mhe", "--horizon", "0"],
        "horizon is 0, expected a whole number of at least 1",
    ),
    "camera rate": (["--camera-rate", "7"], "does not divide the recorded 30 Hz"),
    "camera phase": (["--camera-rate", "10", "--camera-phase", "3"], "expected 0 to 2"),
    "phase alone": (["--camera-phase", "1"], "without --camera-rate"),
    "no camera": (["--sensors", "accel", "--camera-rate", "10"], "exactly one pose_camera"),
    "units": (["--units", "accel"], "expected e.g. accel=g,gyro=deg_s"),
    "duration": (["--duration", "-1"], "duration is -1 s, expected a positive time"),
    "output": (["--output", "o.xls"], "suffix .xls is unknown, expected .csv, .parquet"),
    "unit of nothing": (["--units", "acel=g"], "a unit is given for acel, expected columns of it"),
    "output is a folder": (["--output", "/"], "suffix (none) is unknown"),
    "figure": (["--figure", "o.bmp"], "suffix .bmp is unknown, expected .png, .pdf, .svg"),
    "pen": (["--pen", "nowhere.toml"], "pen file nowhere.toml does not exist"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_calls_get_one_sentence(recording: Path, tmp_path: Path, case: str) -> None:
    options, sentence = BAD[case]
    arguments = ["estimate", str(recording), "--pen", "reference"]
    output = ["--output", str(tmp_path / "o.csv")]
    result = runner.invoke(app, [*arguments, *output, *options])
    assert result.exit_code == 2
    message = result.stderr.strip()
    assert message.startswith("pen-mhe: ")
    assert "\n" not in message
    assert sentence in message
