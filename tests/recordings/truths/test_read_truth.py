"""What others' headers, units, clocks and gaps become as a truth of a pen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import pen_mhe as pm
from models.arrays import Array
from models.errors import InputError
from recordings.asked import Asked
from recordings.formats.tables import recording_to_table
from recordings.truths.read import read_truth
from recordings.truths.track import TruthTrack, angles_of, attitude_of, matrices_of

T = np.arange(50) * 0.01
RISING = np.linspace(0.0, 0.2, 50)


def _read(folder: Path, columns: dict[str, object], **options: object) -> TruthTrack:
    path = folder / "truth.csv"
    pd.DataFrame(columns).to_csv(path, index=False, **options)  # type: ignore[call-overload]
    return read_truth(path, "reference")


@pytest.mark.parametrize(
    ("headers", "factor"),
    [
        (("x_mm", "y_mm", "z_mm"), 1e-3),
        (("Pos X [cm]", "Pos Y [cm]", "Pos Z [cm]"), 1e-2),
        (("tip_x_m", "tip_y_m", "tip_z_m"), 1.0),
        (("true_tip_x_mm", "true_tip_y_mm", "true_tip_z_mm"), 1e-3),
        (("Position.x", "Position.y", "Position.z"), 1.0),
    ],
)
def test_places_come_in_their_unit(tmp_path: Path, headers: tuple[str, ...], factor: float) -> None:
    track = _read(tmp_path, {"time_s": T, **dict.fromkeys(headers, RISING)})
    assert track.position is not None
    np.testing.assert_allclose(track.position, factor * np.column_stack([RISING] * 3), atol=1e-12)
    assert track.attitude is None
    assert track.is_of_pen


def test_places_without_a_unit_that_go_far_are_in_millimetres(tmp_path: Path) -> None:
    track = _read(tmp_path, {"time_s": T, "X": 100 * RISING, "Y": -100 * RISING})
    assert track.position is not None
    np.testing.assert_allclose(track.position[:, 0], 0.1 * RISING)
    assert track.is_level
    assert any("taken in mm" in sentence for sentence in track.said)


def test_quaternions_are_a_markers_and_bad_ones_are_gaps(tmp_path: Path) -> None:
    q = Rotation.from_rotvec(np.outer(RISING, [1, 2, 3])).as_quat()
    q[7] = 0.0
    columns = {f"rb1_q{axis}": column for axis, column in zip("xyzw", q.T, strict=True)}
    track = _read(tmp_path, {"time_s": T, **columns})
    assert track.attitude is not None
    assert not track.is_of_pen
    assert np.isnan(track.attitude[7]).all()
    np.testing.assert_allclose(np.delete(track.attitude, 7, 0), np.delete(q, 7, 0), atol=1e-12)
    with pytest.raises(InputError, match="expected quaternions"):
        _read(tmp_path, {"time_s": T, **dict.fromkeys(columns, 5.0)})


def test_motives_export_turns_before_it_places(tmp_path: Path) -> None:
    lines = ["Format Version,1.23,Take Name,pen", "", "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z"]
    lines += [f"{k},{t:.3f},0,0,0,1,{0.1 + t:.4f},0.2,0.3" for k, t in enumerate(T)]
    path = tmp_path / "take.csv"
    path.write_text("\n".join(lines), "utf-8")
    track = read_truth(path, "reference")
    assert track.position is not None
    assert track.attitude is not None
    np.testing.assert_allclose(track.attitude, np.tile([0, 0, 0, 1.0], (50, 1)), atol=1e-12)
    np.testing.assert_allclose(track.position[:, 0], 0.1 + T, atol=1e-9)


def test_angles_without_a_unit_are_told_by_their_size(tmp_path: Path) -> None:
    degrees = _read(tmp_path, {"ms": 1e3 * T, "azimuth": 200 * RISING, "elevation": 50.0})
    assert degrees.angles is not None
    np.testing.assert_allclose(degrees.angles[:, 1], np.radians(50.0))
    np.testing.assert_allclose(degrees.time_s, T, atol=1e-9)
    assert np.isnan(degrees.angles[:, 2]).all()
    radians = _read(tmp_path, {"time_s": T, "altitude": 0.8})
    assert radians.angles is not None
    np.testing.assert_allclose(radians.angles[:, 1], 0.8)


def test_only_rows_with_the_pen_down_count(tmp_path: Path) -> None:
    down = (T < 0.2).astype(int)
    track = _read(tmp_path, {"time_s": T, "x_mm": RISING, "y_mm": RISING, "pressure": 300 * down})
    assert track.position is not None
    assert np.isnan(track.position[down == 0]).all()
    assert np.isfinite(track.position[down == 1]).all()


def test_nothing_is_between_rows_that_are_far_apart(tmp_path: Path) -> None:
    t = np.append(T, T + 2.0)
    track = _read(tmp_path, {"time_s": t, "elevation_deg": np.degrees(np.sin(3 * t))})
    at = np.array([-0.1, 0.245, 0.6, 1.5, 2.123, 3.0])
    found = track.angles_at(at)[:, 1]
    np.testing.assert_array_equal(np.isnan(found), [True, False, True, True, False, True])
    np.testing.assert_allclose(found[[1, 4]], np.sin(3 * at[[1, 4]]), atol=1e-6)


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 200.0])
def test_what_lies_between_is_of_third_order(rate_hz: float) -> None:
    t = np.arange(0.0, 2.0, 1 / rate_hz)
    track = TruthTrack("curve", t, np.column_stack([np.sin(5 * t), np.cos(5 * t)]))
    at = np.arange(0.2, 1.8, 0.0037)
    away = np.abs(track.positions(at)[:, 0] - np.sin(5 * at)).max()
    assert away < 0.2 * (5 / rate_hz) ** 3


def test_epochs_begin_where_the_recordings_do(tmp_path: Path) -> None:
    path = tmp_path / "epoch.csv"
    pd.DataFrame({"time_s": 1.7e9 + T, "elevation_deg": 40.0}).to_csv(path, index=False)
    np.testing.assert_allclose(read_truth(path, "reference").time_s, T, atol=1e-6)
    behind = read_truth(path, "reference", origin_s=1.7e9 - 10)
    np.testing.assert_allclose(behind.time_s, T + 10, atol=1e-6)


def test_angles_and_attitudes_are_one_another() -> None:
    rng = np.random.default_rng(1)
    angles = rng.uniform([-3, 0.1, -3], [3, 1.5, 3], (200, 3))
    np.testing.assert_allclose(angles_of(matrices_of(attitude_of(angles))), angles, atol=1e-9)


def test_a_recording_with_a_truth_or_a_camera_is_one(tmp_path: Path) -> None:
    pen = pm.load_pen("reference")
    recording = pm.simulate(pen, ["accel", "gyro", "camera"], duration_s=0.5, seed=2)
    table = recording_to_table(recording, pen)
    path = tmp_path / "simulated.csv"
    table.to_csv(path, index=False)
    true = read_truth(path, pen)
    table[[c for c in table if not c.startswith("true_")]].to_csv(path, index=False)
    seen = read_truth(path, pen)
    assert true.position is not None
    assert seen.position is not None
    away = seen.position - true.positions(seen.time_s)
    assert np.nanmax(np.abs(away)) < 5e-3
    assert seen.is_of_pen


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"time_s": T, "volts": T}, "nothing of a pen's motion among time_s, volts"),
        ({"x_mm": T, "y_mm": T}, "no column of times"),
        ({"time_s": [0.0], "elevation_deg": [1.0]}, "expected at least two"),
    ],
)
def test_a_file_of_something_else_is_refused(
    tmp_path: Path, columns: dict[str, object], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        _read(tmp_path, columns)


OWN = np.column_stack([RISING, -RISING, 0.5 * RISING])
NOBODYS = {"clock": 1e3 * T, "u": 1e3 * OWN[:, 0], "v": -1e3 * OWN[:, 1], "w": 1e3 * OWN[:, 2]}


def _asked(folder: Path, table: dict[str, Array], asked: Asked, **options: Any) -> TruthTrack:
    path = folder / "truth.csv"
    pd.DataFrame(table).to_csv(path, index=False, **options)
    return read_truth(path, "reference", asked=asked)


@pytest.mark.parametrize(
    ("columns", "units", "options"),
    [
        ("position=u,-v,w;time=clock", {"position": "mm", "time": "ms"}, {}),
        ("position=U,-V,W;time=100Hz", {"position": "m/1000"}, {}),
        ("position=2,-3,4;time=1", {"position": "mm", "time": "ms"}, {"header": False}),
    ],
)
def test_columns_are_those_that_somebody_names(
    tmp_path: Path, columns: str, units: dict[str, str], options: dict[str, Any]
) -> None:
    track = _asked(tmp_path, NOBODYS, Asked.of(units, columns), **options)
    assert track.position is not None
    np.testing.assert_allclose(track.position, OWN, atol=1e-12)
    np.testing.assert_allclose(track.time_s, T, atol=1e-9)
    assert track.attitude is None


def test_a_file_without_a_header_is_given_one(tmp_path: Path) -> None:
    track = _asked(tmp_path, NOBODYS, Asked.of(columns="time_ms,x_mm,y_mm,z_mm"), header=False)
    assert track.position is not None
    np.testing.assert_allclose(track.position, OWN * [1, -1, 1], atol=1e-12)


def test_named_angles_stand_over_recognised_ones(tmp_path: Path) -> None:
    table = {"time_s": T, "elevation_deg": 0 * T, "heading [deg]": 200 * RISING, "roll": RISING}
    track = _asked(tmp_path, table, Asked.of(columns="azimuth=-heading;spin=roll"))
    assert track.angles is not None
    np.testing.assert_allclose(track.angles[:, 0], np.radians(-200 * RISING), atol=1e-12)
    np.testing.assert_allclose(track.angles[:, 2], RISING, atol=1e-12)
    assert np.isnan(track.angles[:, 1]).all()


def test_a_unit_is_for_columns_that_are_recognised_too(tmp_path: Path) -> None:
    track = _asked(tmp_path, {"time_s": T, "x": RISING, "y": RISING}, Asked.of({"position": "cm"}))
    assert track.position is not None
    np.testing.assert_allclose(track.position[:, 0], 1e-2 * RISING, atol=1e-12)


@pytest.mark.parametrize(
    ("columns", "units", "message"),
    [
        ("position=u,v,w;time=clok", {}, r"no column clok for time.*did you mean clock"),
        ("place=u,v,w;time=clock", {}, r"columns of place is unknown|unknown.*place"),
        ("position=u;time=clock", {}, "1 columns of position, expected 2 or 3"),
        ("quaternion=u,v,w;time=clock", {}, "3 columns of quaternion, expected 4"),
        ("position=u,v,w;time=clock", {"position": "deg"}, "expected m or"),
        ("position=u,v,w;time=clock", {"spin": "deg"}, "a unit is given for spin, which has no"),
        ("position=u,v,w;time=fastHz", {}, "expected a rate like 100Hz"),
    ],
)
def test_what_is_named_wrongly_is_said(
    tmp_path: Path, columns: str, units: dict[str, str], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        _asked(tmp_path, NOBODYS, Asked.of(units, columns))


def test_a_unit_beside_another_in_the_header_is_refused(tmp_path: Path) -> None:
    table = {"time_s": T, "x_mm": RISING, "y_mm": RISING}
    with pytest.raises(InputError, match="unit cm is given for position, and x_mm says another"):
        _asked(tmp_path, table, Asked.of({"position": "cm"}))
