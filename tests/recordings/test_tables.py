"""Recordings as tables: units, gaps, truth, and one sentence for what is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from models.errors import InputError
from models.pen_file import load_pen
from models.units import STANDARD_GRAVITY_M_S2
from recordings.formats.columns import column_units
from recordings.formats.tables import (
    read_table,
    recording_from_table,
    recording_to_table,
    write_table,
)
from recordings.read import read_recording
from recordings.simulate_pen import simulate

PEN = load_pen("reference")


def table(**columns: object) -> pd.DataFrame:
    plain = {"time_s": [0.0, 0.01, 0.02]} | {
        f"accel_{axis}_m_s2": [0.1, 0.2, 0.3] for axis in "xyz"
    }
    return pd.DataFrame({k: v for k, v in (plain | columns).items() if v is not None})


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_round_trip_keeps_readings_and_truth(tmp_path: Path, suffix: str) -> None:
    recording = simulate(PEN, ["accel", "camera"], motion="turn", duration_s=0.2, seed=1)
    path = tmp_path / f"pen{suffix}"
    write_table(recording_to_table(recording, PEN), path)
    again = read_recording(path, PEN)
    np.testing.assert_array_equal(again.time_s, recording.time_s)
    for sensor in ("accel", "camera"):
        np.testing.assert_allclose(
            again.readings[sensor], recording.readings[sensor], rtol=1e-14, equal_nan=True
        )
    assert again.truth is not None
    assert recording.truth is not None
    assert again.truth.names == recording.truth.names
    np.testing.assert_allclose(again.truth.values, recording.truth.values, rtol=1e-14)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("stamps", ["capture", "arrival"])
def test_arrivals_are_columns(tmp_path: Path, suffix: str, stamps: str) -> None:
    recording = simulate(
        PEN, ["accel", "camera"], motion="turn", duration_s=0.2, seed=1, stamps=stamps
    )
    written = recording_to_table(recording, PEN)
    assert [name for name in written.columns if "arrival" in name] == ["camera_arrival_s"]
    write_table(written, tmp_path / f"pen{suffix}")
    again = read_recording(tmp_path / f"pen{suffix}", PEN)
    assert list(again.arrivals) == ["camera"]
    np.testing.assert_array_equal(again.arrivals["camera"], recording.arrivals["camera"])


def test_arrivals_in_any_unit_of_time_and_with_readings_only() -> None:
    found = recording_from_table(table(accel_arrival_ms=[2.0, 12.0, np.nan]).iloc[:2], PEN, "r")
    np.testing.assert_array_equal(found.arrivals["accel"], [0.002, 0.012])
    with pytest.raises(InputError, match="arrivals of camera, which has no readings; expected"):
        recording_from_table(table(camera_arrival_s=[0.0, 0.1, 0.2]), PEN, "r")
    with pytest.raises(InputError, match=r"reading of accel at 0\.02 s arrives at nan s, expected"):
        recording_from_table(table(accel_arrival_s=[0.0, 0.1, np.nan]), PEN, "r")


def test_truth_of_a_recording_stamped_on_arrival() -> None:
    """The truth is then given at more instants than there are readings."""
    recording = simulate(PEN, ["accel", "camera"], motion="turn", duration_s=0.2, stamps="arrival")
    assert recording.truth is not None
    again = recording_from_table(recording_to_table(recording, PEN), PEN, "r").truth
    assert again is not None
    rows = [int(np.flatnonzero(recording.truth.time_s == t)[0]) for t in recording.time_s]
    assert len(rows) < len(recording.truth.time_s)
    np.testing.assert_array_equal(again.values, recording.truth.values[rows])


def test_units_in_the_header() -> None:
    columns = {f"accel_{axis}_m_s2": None for axis in "xyz"}
    columns |= {f"accel_{axis}_g": [1.0, 1.0, 1.0] for axis in "xyz"}
    columns |= {f"gyro_{axis}_deg_s": [180.0, 180.0, 180.0] for axis in "xyz"}
    columns |= {"time_s": None, "time_ms": [0.0, 10.0, 20.0]}
    recording = recording_from_table(table(**columns), PEN, "r")
    np.testing.assert_allclose(recording.readings["accel"], STANDARD_GRAVITY_M_S2)
    np.testing.assert_allclose(recording.readings["gyro"], np.pi)
    np.testing.assert_allclose(recording.time_s, [0, 0.01, 0.02])


def test_units_by_option() -> None:
    columns = {f"accel_{axis}_m_s2": None for axis in "xyz"}
    columns |= {f"accel_{axis}": [2.0, 2.0, 2.0] for axis in "xyz"}
    plain = recording_from_table(table(**columns), PEN, "r")
    in_g = recording_from_table(table(**columns), PEN, "r", units={"accel": "g"})
    np.testing.assert_allclose(plain.readings["accel"], 2.0)
    np.testing.assert_allclose(in_g.readings["accel"], 2.0 * STANDARD_GRAVITY_M_S2)
    with pytest.raises(InputError, match="unit furlong of accel is unknown, expected m_s2 or g"):
        recording_from_table(table(**columns), PEN, "r", units={"accel": "furlong"})


def test_a_unit_applies_to_what_it_measures() -> None:
    """A camera has positions and angles: one unit cannot mean both."""
    camera = {f"camera_{axis}": [100.0] * 3 for axis in ("x", "y", "z")}
    camera |= {f"camera_r{axis}": [0.1] * 3 for axis in ("x", "y", "z")}
    recording = recording_from_table(table(**camera), PEN, "r", units={"camera": "mm"})
    np.testing.assert_allclose(recording.readings["camera"], [[0.1] * 6] * 3)
    with pytest.raises(InputError, match="expected m or cm or mm or rad or deg"):
        recording_from_table(table(**camera), PEN, "r", units={"camera": "g"})


def test_truth_in_any_unit() -> None:
    """Kinematic states of six degrees of freedom, whatever the pen's, and biases."""
    five = PEN.model_copy(update={"degrees_of_freedom": 5})
    columns = {
        "true_tip_x_mm": [1.0, 2.0, 3.0],
        "true_spin_deg": [180.0, None, 90.0],
        "true_tip_z_acceleration_g": [1.0, 1.0, 1.0],
        "true_gyro_bias_x_deg_s": [180.0, 180.0, 180.0],
    }
    for pen in (PEN, five):
        truth = recording_from_table(table(**columns), pen, "r").truth
        assert truth is not None
        assert truth.names == (
            "tip_x_m",
            "spin_rad",
            "tip_z_acceleration_m_s2",
            "gyro_bias_x_rad_s",
        )
        expected = np.array(
            [[1e-3, 2e-3, 3e-3], [np.pi, np.nan, np.pi / 2], [9.80665] * 3, [np.pi] * 3]
        )
        np.testing.assert_allclose(truth.values, expected.T)


def test_a_partial_reading_is_kept() -> None:
    recording = recording_from_table(table(accel_y_m_s2=[0.1, None, 0.3]), PEN, "r")
    np.testing.assert_array_equal(recording.readings["accel"][1], [0.2, np.nan, 0.2])


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_only_an_empty_cell_is_missing_in_a_file(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"pen{suffix}"
    write_table(table(accel_y_m_s2=[9.8, None, 9.8]), path)
    values = read_recording(path, PEN).readings["accel"]
    np.testing.assert_array_equal(np.isnan(values), [[0, 0, 0], [0, 1, 0], [0, 0, 0]])


def test_units_that_the_columns_were_read_in() -> None:
    columns = {f"gyro_{axis}_deg_s": [1.0] * 3 for axis in "xyz"}
    headers = table(**columns).columns
    assert column_units(headers, PEN) == {"accel": "m_s2", "gyro": "deg_s"}
    plain = ["time_s", *(f"accel_{axis}" for axis in "xyz")]
    assert column_units(plain, PEN, units={"accel": "g"}) == {"accel": "g"}
    assert column_units(["time_s", "accel_x_g", "accel_y_mg", "accel_z_g"], PEN) == {}


BAD = {
    "missing column": (
        {"accel_y_m_s2": None},
        r"column accel_y is missing",
    ),
    "unknown column": ({"speed": [1, 2, 3]}, r"unknown column speed, expected time_s, accel_x"),
    "no time": ({"time_s": None}, r"expected exactly one column of time_s, time_ms, time_us"),
    "text": ({"accel_x_m_s2": [0.1, "much", 0.3]}, r"column accel_x_m_s2, row 2: 'much' is not"),
    "infinite": ({"accel_x_m_s2": [0.1, np.inf, 0.3]}, r"column accel_x_m_s2, row 2: 'inf' is not"),
    "backward time": ({"time_s": [0.0, 0.02, 0.01]}, r"time of row 3 \(0.01 s\) does not follow"),
    "repeated time": ({"time_s": [0.0, 0.01, 0.01]}, r"time of row 3 \(0.01 s\) does not follow"),
    "empty time": ({"time_s": [0.0, None, 0.02]}, r"column time_s is empty in row 2"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_tables(case: str) -> None:
    columns, sentence = BAD[case]
    with pytest.raises(InputError, match=sentence):
        recording_from_table(table(**columns), PEN, "r")


def test_empty_and_foreign_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="recording r is empty below its header, expected"):
        recording_from_table(table().iloc[:0], PEN, "r")
    with pytest.raises(InputError, match=r"nothing\.csv does not exist"):
        read_recording(tmp_path / "nothing.csv", PEN)
    with pytest.raises(InputError, match=r"suffix \.xls is unknown, expected \.csv, \.parquet"):
        read_table(tmp_path / "a.xls")
    (tmp_path / "a.parquet").write_text("no")
    with pytest.raises(InputError, match=r"a\.parquet: cannot be read, expected a parquet table"):
        read_table(tmp_path / "a.parquet")
    (tmp_path / "a.csv").write_text("")
    with pytest.raises(InputError, match=r"a\.csv is empty \(zero bytes\), expected a header"):
        read_table(tmp_path / "a.csv")
    with pytest.raises(InputError, match="folder without D-POINT's files"):
        read_recording(tmp_path, PEN)
