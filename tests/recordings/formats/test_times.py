"""Stamps: their units, where they overflow, and what is done where they do not advance."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from models.arrays import Array
from models.errors import InputError
from recordings.foreign.repairs import mended_times
from tests.recordings.formats.logger_files import (
    FORCE,
    RATE,
    T,
    both,
    check,
    read,
    rows,
    said,
    whole,
)

SIX = "ax,ay,az,gx,gy,gz"


@pytest.mark.parametrize(
    ("header", "factor", "start", "unit"),
    [
        ("t", 1.0, 0.0, "s"),
        ("time", 1e3, 5.0, "ms"),
        ("timestamp", 1e6, 5.0, "us"),
        ("ticks", 1e7, 5.0, "100ns"),
        ("clock", 1e9, 5.0, "ns"),
        ("timestamp", 1e3, 1.7e9, "ms"),
        ("timestamp", 1e6, 1.7e9, "us"),
        ("timestamp", 1e9, 1.7e9, "ns"),
        ("timestamp", 1e7, 1.7e9 + 11_644_473_600, "100ns"),
        ("Zeit", 1e7, 1.7e9 + 62_135_596_800, "100ns"),
    ],
)
def test_units(tmp_path: Path, header: str, factor: float, start: float, unit: str) -> None:
    stamps = np.round(T * factor).astype(np.int64) + round(start * factor) if factor > 1 else T
    (tmp_path / "pen.csv").write_text(rows([stamps, *both()], f"{header},{SIX}"))
    assert f"times from {header}, in {unit}" in said(check(read(tmp_path / "pen.csv")))


@pytest.mark.parametrize(
    "form", ["%Y-%m-%dT%H:%M:%S.%fZ", "%Y-%m-%d %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S.%f", "%H:%M:%S.%f"]
)
def test_dates(tmp_path: Path, form: str) -> None:
    """Midnight is passed on the way."""
    dates = pd.Timestamp("2024-05-01T23:59:57") + pd.to_timedelta(T, unit="s")
    lines = rows(both()).splitlines()
    text = "\n".join(f"{d.strftime(form)},{line}" for d, line in zip(dates, lines, strict=True))
    (tmp_path / "pen.csv").write_text(f"when,{SIX}\n{text}".replace("when", "datetime"))
    found = check(read(tmp_path / "pen.csv"))
    assert "times from datetime, dates" in said(found)
    assert ("midnight passed 1 time" in said(found)) == (form[1] == "H")


def test_a_unit_that_cannot_be(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    for name in (
        SIX,
        "accel_x_m_s2,accel_y_m_s2,accel_z_m_s2,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s",
    ):
        path.write_text(rows([T * 1000, *both()], f"time_s,{name}"))
        with pytest.raises(InputError, match=r"time_s was read in s but looks like ms .* time=ms"):
            read(path)
        check(read(path, units={"time": "ms"}))
    with pytest.raises(InputError, match="unit furlong of time is unknown, expected s or ms or us"):
        read(path, units={"time": "furlong"})


def test_rows_at_a_rate(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    path.write_text(rows(both(), SIX))
    with pytest.raises(InputError, match=r'no column of times, expected .*"time=100Hz"'):
        read(path)
    check(read(path, columns="time=100Hz"))


@pytest.mark.parametrize(("name", "factor", "bits"), [("millis", 1e3, 32), ("ms", 1e3, 16)])
def test_overflow(tmp_path: Path, name: str, factor: float, bits: int) -> None:
    stamps = (whole([T * factor])[0] + 2**bits - 3000) % 2**bits
    (tmp_path / "pen.csv").write_text(rows([stamps, *both()], f"{name},{SIX}"))
    assert f"1 overflow of {name} at {2**bits} undone" in said(check(read(tmp_path / "pen.csv")))
    with pytest.raises(InputError, match=r"overflow .* that needs no repair \(--strict\)"):
        read(tmp_path / "pen.csv", strict=True)


def mended(times: Array) -> tuple[Array, str]:
    found = mended_times(times, lambda: np.arange(len(times), dtype=float)[:, None])
    assert (np.diff(found.time_s) > 0).all()
    return found.time_s, "; ".join((*found.repairs, *found.said))


def test_stamps_that_increase_are_left_alone() -> None:
    times, sentences = mended(T + 0.003 * np.sin(7 * T))
    np.testing.assert_array_equal(times, np.round(T + 0.003 * np.sin(7 * T), 9))
    assert not sentences


def test_equal_and_backward_stamps_go_between_their_neighbours() -> None:
    stamps = np.array([0.0, 0.01, 0.01, 0.03, 0.02, 0.05, 0.06])
    times, sentences = mended(stamps)
    assert sentences == "1 equal and 1 backward stamps: 2 times placed between neighbours"
    np.testing.assert_array_equal(times[[0, 1, 5, 6]], [0, 0.01, 0.05, 0.06])
    assert len(times) == len(stamps)


def test_coarse_stamps_keep_their_first() -> None:
    times, _ = mended(np.arange(len(T)) // 2 / 50)
    np.testing.assert_allclose(times, T, atol=1e-9)


def test_one_stamp_far_off_costs_no_other() -> None:
    stamps = T.copy()
    stamps[[100, 300]] = [55.0, -9.0]
    times, sentences = mended(stamps)
    np.testing.assert_allclose(times, T, atol=1e-9)
    assert "2 times placed" in sentences


def test_rows_out_of_order_are_sorted() -> None:
    order = np.arange(len(T))
    order[[50, 51, 52]] = [51, 52, 50]
    found = mended_times(T[order], lambda: np.arange(len(T), dtype=float)[:, None])
    np.testing.assert_allclose(found.time_s, T)
    np.testing.assert_array_equal(order[found.rows], np.arange(len(T)))
    assert "rows out of order at 1 place" in found.repairs[0]


def test_the_longest_session_is_taken() -> None:
    times, sentences = mended(np.where(T < 5, T + 3, T - 5))
    assert len(times) == 500
    assert "the clock begins anew at 1 place: the longest part, rows 1 to 500" in sentences


def test_a_gap_is_said() -> None:
    times, sentences = mended(T[(T < 3) | (T > 4)])
    assert sentences == "1 gap, the longest of 1.02 s at 2.99 s"
    assert len(times) == 699


def test_rows_written_twice(tmp_path: Path) -> None:
    twice = [np.repeat(column, 2) for column in (T, *both())]
    (tmp_path / "pen.csv").write_text(rows(twice, f"t,{SIX}"))
    found = check(read(tmp_path / "pen.csv"), time_s=T, force=FORCE, rate=RATE)
    assert "800 rows written twice left out" in said(found)
