"""The example program makes of a recording what ``pen-mhe estimate`` makes of it."""

from __future__ import annotations

import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from codegen.example import headers
from codegen.folder import export_files
from commands.cli import app
from models.pen import pen_model
from models.pen_file import load_pen
from recordings.formats.columns import recording_columns
from recordings.formats.tables import recording_to_table
from recordings.simulate_pen import simulate
from tests.codegen.exports import made
from tests.codegen.toolchains import STRICT
from tests.engines import needs_compiler

pytestmark = needs_compiler

SENSORS = ("accel", "contact")


@cache
def table() -> pd.DataFrame:
    pen = load_pen("reference")
    return recording_to_table(simulate(pen, SENSORS, motion="turn", duration_s=0.5, seed=3), pen)


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example of a filter in double precision, as CMakeLists.txt builds it."""
    folder = tmp_path_factory.mktemp("example")
    model = pen_model(load_pen("reference"), SENSORS)
    for name, text in export_files(made("ekf", model, form="root"), None, "…").items():
        (folder / name).write_text(text, "utf-8")
    files = ["pen.c", "main.c", "pen_model.c"]
    command = ["gcc", *STRICT, "-O1", *files, "-o", "example", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "example"


def run(program: Path, recording: str, folder: Path) -> subprocess.CompletedProcess[str]:
    (folder / "pen.csv").write_text(recording)
    command = [str(program), str(folder / "pen.csv"), str(folder / "estimates.csv")]
    return subprocess.run(command, capture_output=True, text=True)


def test_it_writes_what_estimate_writes(program: Path, tmp_path: Path) -> None:
    result = run(program, table().to_csv(index=False), tmp_path)
    assert result.returncode == 0, result.stderr
    made_here = tmp_path / "here.csv"
    arguments = ["estimate", str(tmp_path / "pen.csv"), "--pen", "reference", "--estimator", "ekf"]
    arguments += ["--sensors", ",".join(SENSORS), "--output", str(made_here), "--no-watch"]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    ours = pd.read_csv(tmp_path / "estimates.csv")
    wanted = pd.read_csv(made_here).drop(columns="not_observable")  # no C judges that
    assert ours.columns.tolist() == wanted.columns.tolist()
    both = ours.merge(wanted, on="time_s", suffixes=("", "_wanted"))
    assert len(both) == len(wanted) > 40
    assert (both["status"] == both["status_wanted"]).all()
    for column in wanted.columns:
        if f"{column}_std" in wanted.columns:
            error = (both[column] - both[f"{column}_wanted"]) / both[f"{column}_std_wanted"]
            assert error.abs().max() < 1e-6
            stds = both[f"{column}_std"], both[f"{column}_std_wanted"]
            np.testing.assert_allclose(*stds, rtol=1e-6)


def test_headers_are_those_that_estimate_reads() -> None:
    pen = load_pen("reference")
    read = recording_columns(pen, {})
    for header, (place, factor) in headers(pen_model(pen, SENSORS)).items():
        assert read[header].factor == factor
        assert (place < 0) == (read[header].quantity == "time")


def test_other_units_and_an_empty_cell(program: Path, tmp_path: Path) -> None:
    plain = table().drop(columns=[c for c in table() if c.startswith("true_")])
    plain.loc[5, "accel_x_m_s2"] = np.nan
    run(program, plain.to_csv(index=False), tmp_path)
    wanted = pd.read_csv(tmp_path / "estimates.csv")
    other = plain.rename(columns=lambda c: c.replace("time_s", "time_ms").replace("_m_s2", "_g"))
    other["time_ms"] *= 1e3
    for axis in "xyz":
        other[f"accel_{axis}_g"] /= 9.80665
    assert run(program, other.to_csv(index=False), tmp_path).returncode == 0
    ours = pd.read_csv(tmp_path / "estimates.csv")
    numbers = [c for c in wanted if c not in ("status", "step_time_s")]
    np.testing.assert_allclose(ours[numbers], wanted[numbers], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("accel_x_m_s2", "acel_x_m_s2", "accel_x: column is missing"),
        ("time_s", "seconds", "time_s: column is missing"),
        ("accel_y_m_s2", "accel_x_g", "accel_x_g: is given twice"),
    ],
)
def test_a_wrong_header(program: Path, tmp_path: Path, old: str, new: str, sentence: str) -> None:
    result = run(program, table().to_csv(index=False).replace(old, new, 1), tmp_path)
    assert result.returncode == 1
    assert result.stderr.count("\n") == 1
    assert sentence in result.stderr


@pytest.mark.parametrize(
    ("row", "column", "cell", "sentence"),
    [
        (3, "accel_y_m_s2", "much", "row 3, column accel_y: is not a finite number"),
        (3, "accel_y_m_s2", "inf", "row 3, column accel_y: is not a finite number"),
        (4, "time_s", "", "row 4, column time: is empty"),
        (4, "time_s", "0", "row 4, column time: does not follow the one before"),
    ],
)
def test_a_wrong_cell(
    program: Path, tmp_path: Path, row: int, column: str, cell: str, sentence: str
) -> None:
    text = table().astype(object)
    text.loc[row - 1, column] = cell
    result = run(program, text.to_csv(index=False), tmp_path)
    assert result.returncode == 1
    assert result.stderr.count("\n") == 1
    assert sentence in result.stderr


@pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake is not installed")
def test_cmake_builds_it(program: Path) -> None:
    folder = program.parent
    for command in (["cmake", "-B", "build"], ["cmake", "--build", "build"]):
        result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert result.returncode == 0, result.stdout + result.stderr
    assert (folder / "build" / "pen_example").is_file()
    assert (folder / "build" / "libpen.a").is_file()
