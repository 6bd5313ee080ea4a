"""Turntable files: the paper's numbers, and one sentence for every mistake."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from models.errors import InputError
from models.turntable import load_turntable, paper_turntable, turntable_model

PAPER = (resources.files("models") / "turntables" / "pen_paper.toml").read_text("utf-8")


def load_changed(folder: Path, old: str, new: str) -> None:
    assert PAPER.count(old) == 1
    path = folder / "my_table.toml"
    path.write_text(PAPER.replace(old, new), "utf-8")
    load_turntable(path)


def test_ranges_and_rates_of_the_paper() -> None:
    phi, theta = paper_turntable().axes
    assert np.degrees(phi.range_rad) == pytest.approx([0, 355])
    assert np.degrees(theta.range_rad) == pytest.approx([-10, 60])
    assert np.degrees([phi.rate_rad_s, theta.rate_rad_s]) == pytest.approx([5.1, 3.6])
    tolerances = [phi.rate_tolerance_rad_s, theta.rate_tolerance_rad_s]
    assert np.degrees(tolerances) == pytest.approx([1.0, 0.5])


def test_sensors_of_the_paper() -> None:
    """500 µg/√Hz and 0.05 °/s/√Hz behind a single pole of 50 Hz, 100 Hz per channel."""
    model = turntable_model(paper_turntable())
    noise_bandwidth = np.pi / 2 * 50
    accel, gyro = model.sensor("accel"), model.sensor("gyro")
    force_std = 500e-6 * 9.80665 * np.sqrt(noise_bandwidth)
    assert accel.noise_std == pytest.approx([force_std] * 3, rel=1e-12)
    rate_std = np.radians(0.05 * np.sqrt(noise_bandwidth))
    assert gyro.noise_std == pytest.approx([rate_std] * 2, rel=1e-12)
    assert (accel.rate_hz, gyro.rate_hz) == (100.0, 100.0)
    assert (accel.axes, gyro.axes) == (("x", "y", "z"), ("x", "y"))


def test_states_are_told_from_the_pens() -> None:
    assert turntable_model(paper_turntable()).state_names == (
        "tilt_phi_rad",
        "tilt_theta_rad",
        "tilt_phi_rate_rad_s",
        "tilt_theta_rate_rad_s",
    )


def test_sensors_in_the_order_asked_for() -> None:
    model = turntable_model(paper_turntable(), ["gyro", "accel"])
    assert model.reading_names == ("gyro_x", "gyro_y", "accel_x", "accel_y", "accel_z")


@pytest.mark.parametrize(
    ("sensors", "message"),
    [
        (["camera"], "sensor camera is not in the turntable .*; expected one of accel, gyro"),
        (["gyro", "gyro"], "sensors gyro, gyro: a name appears twice, expected each once"),
    ],
)
def test_wrong_sensors(sensors: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        turntable_model(paper_turntable(), sensors)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('preset = "ADXL202"', 'preset = "ADXL999"', "sensors.accel.preset: unknown preset"),
        ("rate_deg_s = 5.1\nrate_tol", "rate_deg_s = -5.1\nrate_tol", "tilt_phi.rate_rad_s"),
        ("[-10.0, 60.0]", "[60.0, -10.0]", "tilt_theta.range_rad: expected the lower end"),
        ("[tilt_theta]", "[tilt_psi]", "unknown key tilt_psi"),
        ("[sensors.accel]", "[sensors.accel", "expected TOML"),
    ],
)
def test_mistakes(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as raised:
        load_changed(tmp_path, old, new)
    assert str(raised.value).startswith(f"turntable file {tmp_path / 'my_table.toml'}: ")


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"turntable file .*absent\.toml: .*expected a readable"):
        load_turntable(tmp_path / "absent.toml")
