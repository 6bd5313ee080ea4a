"""Which pen is taken where nobody names one, and what `pen-mhe estimate` then writes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from commands.cli import app
from estimation.recording import Recording
from models.errors import InputError
from models.pen_file import load_pen
from pen_mhe.estimate_run import estimate
from pen_mhe.no_pen.which import pen_of
from recordings.formats.dpoint import CAMERA_FILE, STYLUS_FILE
from recordings.formats.tables import recording_to_table, write_table
from recordings.motion_list import motion_names
from recordings.read import read_written
from recordings.simulate_pen import simulate
from tests.recordings.rods import proper_mountings
from tests.references.leaning_rod import leaning_rod

MOUNTING = proper_mountings()[3]
ROD = leaning_rod(1, MOUNTING, duration_s=5.0, rest_s=2.0)


@pytest.fixture
def logged(tmp_path: Path) -> Path:
    """A rod as a stranger's logger writes it."""
    columns = {"millis": 1e3 * ROD.time_s}
    columns |= {f"a{axis}": ROD.force[:, i] / 9.80665 for i, axis in enumerate("xyz")}
    columns |= {f"g{axis}": np.degrees(ROD.rate[:, i]) for i, axis in enumerate("xyz")}
    path = tmp_path / "log.csv"
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def test_a_simulated_recording_is_of_the_reference_pen(tmp_path: Path) -> None:
    pen, path = load_pen("reference"), tmp_path / "pen.csv"
    recording = simulate(pen, ["accel", "gyro"], duration_s=0.3)
    write_table(recording_to_table(recording, pen), path)
    for each in (recording, path, [path]):
        which = pen_of(each)
        assert which.pen == pen
        assert which.found is None
        assert "simulated" in which.note
    assert pen_of(path, "z").found is not None


def test_a_dpoint_folder_is_of_the_dpoint_pen(tmp_path: Path) -> None:
    for name in (STYLUS_FILE, CAMERA_FILE):
        (tmp_path / name).write_text("{}")
    assert pen_of(tmp_path).pen == pen_of([tmp_path]).pen == load_pen("dpoint")


def test_anybody_elses_pen_is_found(logged: Path) -> None:
    which = pen_of(logged)
    assert which.found is not None
    assert which.loaded is not None
    rows = np.array(which.pen.sensors["accel"].sensor_to_body)
    np.testing.assert_allclose(rows[2], MOUNTING[2], atol=1e-9)
    assert any(note.startswith("axis: ") for note in which.loaded.notes)


def test_an_axis_beside_a_pen_is_refused(logged: Path) -> None:
    with pytest.raises(InputError, match="axis z is given with a pen, expected one of both"):
        estimate(logged, "reference", axis="z")


@pytest.mark.usefixtures("interpreted")
def test_the_command_writes_table_figure_and_pen(logged: Path) -> None:
    out, drawn = logged.parent / "out.csv", logged.parent / "out.png"
    words = ["estimate", str(logged), "--output", str(out), "--figure", str(drawn)]
    words += ["--estimator", "ekf", "--duration", "1"]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert "no pen file: the pen is what the recording shows" in result.output
    pen = load_pen(logged.parent / "log_pen.toml")
    assert pen.sensors["gyro"].reads_rate
    table = pd.read_csv(out)
    unseen = set(table["not_observable"][10:])  # the first instants know less
    assert unseen == {"tip_x_m+tip_y_m+tip_z_m+azimuth_rad"}
    assert drawn.stat().st_size > 10_000
    (logged.parent / "log_pen.toml").write_text("# mine\n")
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 2
    assert "was edited, expected --pen" in result.stderr


@pytest.mark.usefixtures("interpreted")
def test_a_pen_file_without_rest_is_given_it_where_the_recording_is_still() -> None:
    pen = pen_of(recorded()).pen
    bare = pen.model_copy(
        update={"sensors": {k: s for k, s in pen.sensors.items() if not s.is_rest}}
    )
    runs = {
        rest: estimate(recorded(), bare, estimator="ekf", rest=rest, duration_s=1.5)
        for rest in (True, False)
    }
    assert [any(s.is_derived for s in run.model.sensors) for run in runs.values()] == [True, False]
    assert any("one is added" in note for note in runs[True].notes)
    moving = recorded(since_s=3.2)
    run = estimate(moving, bare, estimator="ekf", duration_s=0.2)
    assert not any(sensor.is_derived for sensor in run.model.sensors)


def recorded(since_s: float = 0.0) -> Recording:
    kept = ROD.time_s >= since_s
    sensors = {"accel": ROD.force, "gyro": ROD.rate}
    return Recording.from_sensors(
        "rod", {k: (ROD.time_s[kept], v[kept]) for k, v in sensors.items()}
    )


@pytest.mark.slow
@pytest.mark.parametrize("pen", ["reference", "dpoint"])
@pytest.mark.parametrize("motion", motion_names())
def test_what_is_simulated_is_read_whatever_the_seed(pen: str, motion: str, tmp_path: Path) -> None:
    config = load_pen(pen)
    for seed in range(12):
        path = tmp_path / ("pen.parquet" if seed % 2 else "pen.csv")
        recording = simulate(config, motion=motion, seed=seed)
        write_table(recording_to_table(recording, config), path)
        read = read_written(path, config).recording
        kept = {name for name, y in recording.readings.items() if np.isfinite(y).any()}
        assert set(read.readings) == kept


def test_the_readme_s_own_example_is_read(tmp_path: Path) -> None:
    """Seed 3 never touches the paper: its contact has columns, and no reading."""
    pen, path = load_pen("reference"), tmp_path / "pen.csv"
    recording = simulate(pen, motion="handwriting", seed=3)
    write_table(recording_to_table(recording, pen), path)
    written = read_written(path, pen)
    assert "contact" not in written.recording.readings
    assert "contact has no reading, left out" in written.notes
