"""`pm.estimate` and `pen-mhe estimate` watch unless told not to, and say what was found."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import pen_mhe as pm
from commands.cli import app
from estimation.watch.flags import Flag
from models.pen_file import load_pen
from recordings.formats.tables import recording_to_table, write_table

DATA = os.environ.get("PEN_MHE_DATA")
SENSORS = ("accel", "gyro", "camera")
STUCK_S = (0.7, 0.9)


@cache
def recording() -> pm.Recording:
    return pm.simulate("reference", SENSORS, motion="handwriting", duration_s=1.2, seed=3)


@cache
def stuck() -> pm.Recording:
    """The gyroscope repeats its last reading."""
    parts = {name: recording().sensor(name) for name in SENSORS}
    time_s, values = parts["gyro"]
    hit = (time_s >= STUCK_S[0]) & (time_s < STUCK_S[1])
    values = np.where(hit[:, None], values[np.flatnonzero(hit)[0] - 1], values)
    return pm.Recording.from_sensors(
        "stuck", {**parts, "gyro": (time_s, values)}, truth=recording().truth
    )


def estimated(given: pm.Recording, **options: Any) -> Any:
    return pm.estimate(given, sensors=SENSORS, estimator="ekf", **options)


def test_nothing_changes_where_nothing_is_wrong() -> None:
    watched, bare = (estimated(recording(), watch=watch) for watch in (True, False))
    np.testing.assert_array_equal(watched.history.mean, bare.history.mean)
    np.testing.assert_array_equal(watched.history.std, bare.history.std)
    assert watched.history.status == bare.history.status
    assert "watched: nothing was flagged, nothing was lost" in watched.sentences()
    assert not any("watched" in sentence for sentence in bare.sentences())


def test_it_is_watched_by_default() -> None:
    run = estimated(stuck())
    assert run.history.sensor_names == tuple(sensor.name for sensor in run.model.sensors)
    gyro = run.history.flagged[:, SENSORS.index("gyro")]
    times = run.history.time_s[(gyro & Flag.STUCK.value) != 0]
    assert STUCK_S[0] <= times.min() < times.max() < STUCK_S[1]
    assert len(times) > 10
    is_stuck = np.array([pm.Status.STUCK in status for status in run.history.status])
    np.testing.assert_array_equal(is_stuck, (gyro & Flag.STUCK.value) != 0)
    assert any(sentence.startswith("gyro stuck: from 0.7") for sentence in run.sentences())
    table = run.output.to_pandas()
    assert set(table["flagged"]) == {"", "gyro:stuck"}


def test_a_run_that_is_not_watched_has_no_flags() -> None:
    run = estimated(stuck(), watch=False)
    assert run.history.sensor_names == ()
    assert "flagged" not in run.output.to_pandas()


def test_a_smoothed_run_is_bare_and_cannot_be_watched() -> None:
    run = estimated(recording().first(0.3), smooth=True)
    assert run.history.sensor_names == ()
    with pytest.raises(pm.InputError, match="a run is watched and smooth, expected one"):
        estimated(recording(), smooth=True, watch=True)


def test_on_lost_is_a_watchs() -> None:
    assert estimated(recording().first(0.3), on_lost="hold").history.sensor_names
    with pytest.raises(
        pm.InputError, match="on_lost stay is unknown, expected one of restart, hold"
    ):
        estimated(recording(), on_lost="stay")
    with pytest.raises(pm.InputError, match="on_lost is 'hold' of a run that is not watched"):
        estimated(recording(), on_lost="hold", watch=False)


def test_settings_of_a_watch_are_checked() -> None:
    ekf = pm.create_estimator("ekf", pm.pen_model("reference", SENSORS))
    assert pm.watched(ekf, on_lost="hold").config.on_lost == "hold"
    with pytest.raises(pm.InputError, match="setting on_loss is not read by the watch"):
        pm.watched(ekf, on_loss="hold")


@pytest.mark.parametrize(
    ("options", "flagged"), [([], True), (["--on-lost", "hold"], True), (["--no-watch"], False)]
)
def test_the_command_watches_too(tmp_path: Path, options: list[str], flagged: bool) -> None:
    given, written = tmp_path / "pen.csv", tmp_path / "estimate.csv"
    write_table(recording_to_table(stuck(), pm.load_pen("reference")), given)
    words = f"--pen reference --estimator ekf --output {written}".split()
    result = CliRunner().invoke(app, ["estimate", str(given), *words, *options])
    assert result.exit_code == 0, result.stderr
    table = pd.read_csv(written, keep_default_na=False)
    assert ("flagged" in table) == flagged
    said = " ".join(result.stdout.split())
    assert ("gyro stuck: from 0.7" in said) == flagged
    if flagged:
        assert "gyro:stuck" in set(table["flagged"])


def test_what_makes_no_sense_together_is_refused(tmp_path: Path) -> None:
    written = tmp_path / "estimate.csv"
    given = tmp_path / "pen.csv"
    write_table(recording_to_table(recording(), pm.load_pen("reference")), given)
    words = f"--pen reference --estimator ekf --output {written} --no-watch --on-lost hold".split()
    result = CliRunner().invoke(app, ["estimate", str(given), *words])
    assert result.exit_code == 2
    assert "of a run that is not watched" in " ".join(result.stderr.split())
    assert not written.exists()


@pytest.mark.skipif(not DATA, reason="PEN_MHE_DATA is not set: no real recordings here")
@pytest.mark.parametrize("pen", ["dpoint", "told nothing"])
@pytest.mark.parametrize("sensors", [None, pytest.param(["accel", "gyro"], marks=pytest.mark.slow)])
def test_a_real_pen_that_is_not_broken_is_left_alone(pen: str, sensors: list[str] | None) -> None:
    """What is usual was found on the first half; a pen told nothing of it is left alone too."""
    config = load_pen("dpoint")
    if pen == "told nothing":
        untold = {
            name: sensor.model_copy(update={"usual_innovations": None})
            for name, sensor in config.sensors.items()
        }
        config = config.model_copy(update={"sensors": untold})
    assert DATA is not None
    folder = Path(DATA) / "dpoint_pen"
    watched, bare = (
        pm.estimate(folder, config, estimator="ekf", sensors=sensors, watch=watch).history
        for watch in (True, False)
    )
    np.testing.assert_array_equal(watched.mean, bare.mean)
    assert watched.status == bare.status
    assert not watched.flagged.any()
