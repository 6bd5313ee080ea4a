"""``pen-mhe codegen``: what it writes, and one sentence for what it cannot."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from commands import codegen_run
from commands.cli import app

FILES = {"pen.h", "pen.c", "pen_model.c", "main.c", "CMakeLists.txt", "README.md"}


def call(folder: Path, *options: str) -> Any:
    return CliRunner().invoke(app, ["codegen", "--output", str(folder), *options])


@pytest.fixture
def unmeasured(monkeypatch: pytest.MonkeyPatch) -> None:
    """Do not compile, to be quick."""
    monkeypatch.setattr(codegen_run, "find_target", lambda: None)


@pytest.mark.cover
@pytest.mark.usefixtures("unmeasured")
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
@pytest.mark.parametrize("precision", [(), ("--float32",)])
def test_a_folder_has_everything(name: str, precision: tuple[str, ...], tmp_path: Path) -> None:
    folder = tmp_path / "made"
    result = call(folder, "--sensors", "accel", "--estimator", name, *precision)
    assert result.exit_code == 0, result.stderr
    assert {path.name for path in folder.iterdir()} == FILES
    real = "float" if precision else "double"
    assert f"typedef {real} pen_real;" in (folder / "pen.h").read_text()
    assert "Not measured" in (folder / "README.md").read_text()


@pytest.mark.usefixtures("unmeasured")
def test_horizon_and_prefix(tmp_path: Path) -> None:
    options = ("--sensors", "accel", "--estimator", "mhe-rti", "--float32")
    call(tmp_path, *options, "--horizon", "7", "--prefix", "nib")
    source = (tmp_path / "nib.c").read_text()
    assert ".n_stages = 8," in source
    assert "int nib_step(" in source


@pytest.mark.usefixtures("unmeasured")
def test_lags(tmp_path: Path) -> None:
    options = ("--sensors", "accel", "--horizon", "7")
    call(tmp_path, *options, "--lag-samples", "2", "--lag-samples", "5")
    header = (tmp_path / "pen.h").read_text()
    assert "PEN_LAG_2 = 0, " in header
    assert "PEN_LAG_5 = 1, " in header
    refused = call(tmp_path, *options, "--lag-samples", "8")
    assert refused.exit_code == 2
    assert "expected at most 7" in refused.stderr
    refused = call(tmp_path, *options[:2], "--estimator", "ekf", "--lag-samples", "8")
    assert "lag_samples" in refused.stderr


@pytest.mark.usefixtures("unmeasured")
def test_taking_late_readings_needs_room(tmp_path: Path) -> None:
    """A state of a filter keeps what it goes back to; a window has it anyway."""
    options = ("--sensors", "accel", "--estimator", "ekf", "--late-samples")
    sizes = []
    for samples in ("0", "7"):
        assert call(tmp_path / samples, *options, samples).exit_code == 0
        [size] = re.findall(r"memory\[2\]\[(\d+)\]", (tmp_path / samples / "pen.h").read_text())
        sizes.append(int(size))
    assert sizes[1] > 3 * sizes[0]
    refused = call(tmp_path / "mhe", "--sensors", "accel", "--late-samples", "7")
    assert "late_samples is not read by mhe-rti" in refused.stderr
    refused = call(tmp_path / "mhe", *options, "-1")
    assert "late_samples is -1, expected a whole number from 0" in refused.stderr


@pytest.mark.usefixtures("unmeasured")
def test_roots_in_double_too(tmp_path: Path) -> None:
    for options, form in (((), "covariance form"), (("--roots",), "root form")):
        call(tmp_path, "--sensors", "accel", "--estimator", "ekf", *options)
        told = (tmp_path / "README.md").read_text()
        assert "\n`ekf` for reference pen" in told
        assert f"double, {form}" in told


@pytest.mark.parametrize("more", [("ekf",), ("mhe-rti", "--horizon", "2", "--deadline", "0.01")])
def test_sizes_are_told(more: tuple[str, ...], tmp_path: Path) -> None:
    result = call(tmp_path, "--sensors", "accel", "--float32", "--estimator", *more)
    assert result.exit_code == 0, result.stderr
    told = (tmp_path / "README.md").read_text()
    assert ("within 0.01 s" in told) == ("--deadline" in more)
    assert "flash" in result.stdout
    assert "| flash: code, tables |" in (tmp_path / "README.md").read_text()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--estimator", "mhe"), "estimator mhe cannot be exported as C, expected one of ekf, mhe"),
        (("--estimator", "kalman"), "estimator kalman cannot be exported as C"),
        (("--estimator", "ekf", "--horizon", "5"), "horizon is not read by ekf, expected one of"),
        (("--estimator", "ekf", "--deadline", "1"), "deadline_s is not read by ekf, expected one"),
        (("--deadline", "-1"), "deadline_s is -1"),
        (
            ("--estimator", "mhe-rti", "--horizon", "0"),
            "horizon is 0, expected a whole number of at least 1",
        ),
        (("--sensors", "acel"), "acel"),
        (("--sensors", "area"), "sensors area have no readings of their own"),
        (("--sensors", ","), "has no name in it"),
        (("--pen", "absent.toml"), "pen file absent.toml does not exist"),
        (("--prefix", "My-Pen"), "prefix 'My-Pen', expected small letters"),
    ],
)
def test_bad_input(options: tuple[str, ...], sentence: str, tmp_path: Path) -> None:
    result = call(tmp_path / "made", *options)
    assert result.exit_code == 2
    assert result.stdout == ""
    message = result.stderr.strip()
    assert message.startswith("pen-mhe: ")
    assert "\n" not in message
    assert sentence in message
    assert not (tmp_path / "made").exists()


def test_an_output_that_is_a_file(tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.write_text("mine")
    result = call(taken, "--sensors", "accel", "--estimator", "ekf")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "expected a folder that can be written" in result.stderr
    assert taken.read_text() == "mine"
