"""Hard and soft iron from a pen that is turned about: found, as sure as claimed, and written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom, norm
from typer.testing import CliRunner

import pen_mhe as pm
from commands.cli import app
from models.errors import InputError
from pen_mhe.calibration.magnetometer import calibrate_magnetometer
from recordings.formats.tables import recording_to_table, write_table
from tests.pen_mhe.calibration.turns import DIP_RAD, NOISE_UT, STRENGTH_UT, turned, turned_pen

RUNS = 20
PEN_FILE = """name = "turned"  # mine
[sensors.accel]
kind = "accelerometer"
noise_density_m_s2_per_sqrt_hz = 0.002
bandwidth_hz = 50.0

# the compass
[sensors.mag]
kind = "magnetometer"
field_strength_ut = 48.0
field_dip_deg = 60.0
noise_std_mgauss = 8.0
bias_std_ut = 20.0
"""


def test_it_is_exact_without_noise() -> None:
    truth = turned(0, duration_s=20.0, noise=0.0)
    found = calibrate_magnetometer(truth.recording, turned_pen()).sensors["mag"]
    np.testing.assert_allclose(found.fit.values, truth.parameters, rtol=0, atol=1e-7)
    assert found.dip_rad is not None
    assert found.dip_rad[0] == pytest.approx(DIP_RAD, abs=1e-8)


def test_it_begins_far_away() -> None:
    """Iron of five times the field, from a file that knows of none."""
    truth = turned(4, duration_s=20.0)
    hard = np.array([200.0, -100.0, 50.0])
    readings = {"mag": truth.recording.readings["mag"] + hard}
    moved = pm.Recording("moved", truth.recording.time_s, readings)
    found = calibrate_magnetometer(moved, turned_pen()).sensors["mag"]
    np.testing.assert_allclose(found.fit.bias, truth.bias + hard, atol=0.2)


@pytest.mark.parametrize("runs", [5, pytest.param(3 * RUNS, marks=pytest.mark.slow)])
def test_errors_are_as_large_as_claimed(runs: int) -> None:
    """Within two deviations in 95 % of all numbers, and what chance explains once in a thousand."""
    within = []
    for seed in range(100, 100 + runs):
        truth = turned(seed)
        found = calibrate_magnetometer(truth.recording, turned_pen()).sensors["mag"]
        within.append(np.abs(found.fit.values - truth.parameters) < 2 * found.fit.std)
        assert found.noise_ut == pytest.approx(NOISE_UT, rel=0.05)
    two = norm.cdf(2) - norm.cdf(-2)
    assert np.sum(within) >= binom.ppf(1e-3, np.size(within), two)
    assert (np.sum(within, axis=0) >= binom.ppf(1e-4, runs, two)).all()
    if runs > RUNS:
        assert np.mean(within) < 0.985  # nor much less sure than it is


def test_few_turns_are_refused() -> None:
    truth = turned(2)
    flat = truth.recording.first(0.3)
    with pytest.raises(InputError, match="mag has 31 complete readings, expected at least 100"):
        calibrate_magnetometer(flat, turned_pen())
    with pytest.raises(InputError, match="its turns are too few to tell"):
        calibrate_magnetometer(truth.recording.first(1.5), turned_pen())


def test_names_are_checked() -> None:
    truth = turned(2, duration_s=5.0)
    with pytest.raises(InputError, match="magnetometer accel is unknown"):
        calibrate_magnetometer(truth.recording, turned_pen(), sensors="accel")
    with pytest.raises(InputError, match="no magnetometer to calibrate"):
        calibrate_magnetometer(truth.recording.select(["accel"]), turned_pen())


def test_the_command_writes_a_pen_file(tmp_path: Path) -> None:
    pen, recording, new = (tmp_path / name for name in ("pen.toml", "turns.csv", "new.toml"))
    pen.write_text(PEN_FILE, "utf-8")
    truth = turned(3)
    write_table(recording_to_table(truth.recording, turned_pen()), recording)
    words = ["calibrate", "magnetometer", recording, "--pen", pen, "--output", new]
    result = CliRunner().invoke(app, list(map(str, words)), prog_name="pen-mhe")
    assert result.exit_code == 0, result.output
    said = " ".join(result.stdout.split())
    assert f"mag: |B| is off {STRENGTH_UT:g} µT by" in said
    assert "by gravity the field's dip is 64.0°" in said
    assert "the pen file says 60.0°: is field_dip right" in said
    mag = pm.load_pen(new).sensors["mag"]
    np.testing.assert_allclose(mag.bias_ut, truth.bias, atol=0.1)  # type: ignore[attr-defined]
    np.testing.assert_allclose(mag.sensitivity, truth.S, atol=2e-3)  # type: ignore[attr-defined]
    assert 0.01 < mag.bias_std_ut < 0.1  # type: ignore[attr-defined]
    assert mag.noise_std_ut == pytest.approx(NOISE_UT, rel=0.05)  # type: ignore[attr-defined]
    text = new.read_text("utf-8")
    assert "# the compass" in text
    assert "noise_std_mgauss = 4." in text  # in the file's unit
    assert "calibrate magnetometer" in text
    again = calibrate_magnetometer(truth.recording, new)
    assert again.to_toml().count("#   mag bias x: ") == 1
