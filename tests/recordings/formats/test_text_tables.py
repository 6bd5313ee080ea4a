"""Texts: delimiters, decimals, lines above the header, encodings, gzip, and what is no row."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from models.errors import InputError
from recordings.foreign.sniffing import sniffed
from tests.recordings.formats.logger_files import (
    DEG,
    FORCE,
    RATE,
    G,
    T,
    both,
    check,
    millis,
    read,
    rows,
    said,
)

HEADER = "millis,ax,ay,az,gx,gy,gz"
GERMAN = (
    "Zeit [s];Beschl. X [g];Beschl. Y [g];Beschl. Z [g];"
    "Drehrate X [°/s];Drehrate Y [°/s];Drehrate Z [°/s]"
)
PLAIN = rows([millis(), *both()], HEADER)


def german(end: str = "\r\n") -> str:
    return rows([T, *both(G, DEG)], GERMAN, sep=";", decimal=",", end=end)


def spread(text: str, sep: str) -> str:
    return text.replace(",", sep)


CASES: dict[str, tuple[bytes, str]] = {
    "tabs.tsv": (spread(PLAIN, "\t").encode(), "separated by tabs"),
    "blanks.txt": (spread(PLAIN, "   ").encode(), "separated by blanks"),
    "bars.dat": (spread(PLAIN, "|").encode(), "separated by bars"),
    "german.csv": (german().encode("latin-1"), "semicolons, decimal comma, encoding cp1252"),
    "utf16.csv": (german().encode("utf-16"), "encoding utf-16"),
    "unmarked.csv": (german().encode("utf-16-le"), "encoding utf-16-le"),
    "mark.csv": (b"\xef\xbb\xbf" + PLAIN.encode(), "millis, in ms"),
    "packed.csv.gz": (gzip.compress(PLAIN.encode()), "millis, in ms"),
    "above.csv": (
        ("# Device: pen\n# Start, 12:00\n\nInit OK\n" + PLAIN).encode(),
        "4 lines before the header skipped",
    ),
    "comment.txt": (spread("# " + PLAIN, " ").encode(), "millis, in ms"),
    "quoted.csv": (PLAIN.replace(HEADER, '"' + HEADER.replace(",", '","') + '"').encode(), ""),
    "units.csv": (
        rows([millis(), *both(G, DEG)],
             HEADER.replace("millis", "t") + "\nms,g,g,g,deg/s,deg/s,deg/s").encode(),
        "accel from ax [g], ay [g], az [g] in g",
    ),
    "index.csv": (
        rows([np.arange(len(T)), T, *both()], ",time_s,ax,ay,az,gx,gy,gz").encode(),
        "not needed, ignored: column 1",
    ),
    "quoted_commas.csv": (
        "\n".join(
            ",".join(f'"{cell}"' for cell in line.split(";"))
            for line in german("\n").splitlines()
        ).encode(),
        "decimal comma",
    ),
    "trailing.csv": (PLAIN.replace("\n", ",\n").encode(), ""),
    "keys.txt": (
        "\n".join(
            ",".join(f"{k}:{v}" for k, v in zip(HEADER.split(","), line.split(","), strict=True))
            for line in PLAIN.splitlines()[1:]
        ).encode(),
        "millis, in ms",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_any_text(tmp_path: Path, name: str) -> None:
    data, sentence = CASES[name]
    (tmp_path / name).write_bytes(data)
    assert sentence in said(check(read(tmp_path / name)))


def with_lines(*lines: str) -> Callable[[str], str]:
    def put(text: str) -> str:
        found = text.splitlines()
        for number, line in enumerate(lines):
            found.insert(200 + 100 * number, line)
        return "\n".join(found) + "\n"

    return put


@pytest.mark.parametrize(
    ("change", "left_out", "n"),
    [
        (with_lines("BMI270 restarted"), 1, 0),
        (with_lines("BMI270 restarted, hello", "1234,", "1,2,3,4,5,6,7,8,9"), 3, 0),
        (lambda text: text[:-30], 1, 1),
        (with_lines("", "  "), 0, 0),
    ],
)
def test_lines_that_are_no_rows(
    tmp_path: Path, change: Callable[[str], str], left_out: int, n: int
) -> None:
    path = tmp_path / "pen.csv"
    path.write_text(change(PLAIN))
    kept = len(T) - n
    found = check(read(path), time_s=T[:kept], force=FORCE[:kept], rate=RATE[:kept])
    assert (f"repaired: pen.csv: {left_out} line" in said(found)) == bool(left_out)
    if left_out:
        with pytest.raises(InputError, match="left out, no row of 7 cells, expected a file"):
            read(path, strict=True)
    else:
        read(path, strict=True)


@pytest.mark.parametrize("spelling", ["NaN", "nan", "NA", "null", "-", "", "None", "N/A", " "])
def test_spellings_of_no_reading(tmp_path: Path, spelling: str) -> None:
    lines = PLAIN.splitlines()
    for k in (5, 9):
        cells = lines[k + 1].split(",")
        lines[k + 1] = ",".join([*cells[:2], spelling, *cells[3:]])
    path = tmp_path / "pen.csv"
    path.write_text("\n".join(lines))
    accel = read(path).recording.readings["accel"]
    assert np.argwhere(np.isnan(accel)).tolist() == [[5, 1], [9, 1]]


def test_a_word_among_numbers_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    lines = PLAIN.splitlines()
    lines[4] = lines[4].replace(lines[4].split(",")[2], "much")
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match="column ay, row 4: 'much' is not a finite number"):
        read(path)


def test_no_header(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    path.write_text(PLAIN.partition("\n")[2])
    assert "no header: columns 2, 3, 4 for accelerometer x, y, z" in said(check(read(path)))
    check(read(path, columns="time=1;accel=2,3,4;gyro=5,6,7"))
    check(read(path, columns=HEADER))
    with pytest.raises(InputError, match="8 names for 7 columns"):
        read(path, columns=HEADER + ",more")


def test_headers_that_do_not_fit(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    path.write_text(PLAIN.replace("az,gx", "az"))
    with pytest.raises(InputError, match="its header has 6 cells and its first row 7"):
        read(path)


def test_no_table(tmp_path: Path) -> None:
    for name, text in (
        ("a.txt", "once upon a time\nthere was\n"),
        ("b.txt", "\n\n"),
        ("c.log", "7"),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError, match="is a row of numbers, expected a table of numbers"):
            read(tmp_path / name)
    (tmp_path / "d.csv.gz").write_bytes(gzip.compress(PLAIN.encode())[:-40])
    with pytest.raises(InputError, match="cannot be unpacked, expected a whole gzip file"):
        read(tmp_path / "d.csv.gz")


def test_packed_without_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "pen.csv.gz"
    path.write_bytes(gzip.compress(PLAIN.encode()))
    monkeypatch.setenv("PEN_MHE_MOST_UNPACKED_BYTES", "1000")
    with pytest.raises(InputError, match="bytes of a table that was packed, unpacked, expected"):
        read(path)


def test_cells_and_rows_have_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "pen.txt"
    path.write_text(spread(PLAIN, ";") + "0;" + "1" * 201 + ";0;0;0;0;0\n")
    with pytest.raises(InputError, match="line 802 of the file: 201 bytes of a cell"):
        read(path)
    path.write_text(spread(PLAIN, ";"))
    for name in ("ROWS", "VALUES"):
        monkeypatch.setenv(f"PEN_MHE_MOST_{name}", "700")
        with pytest.raises(InputError, match="expected at most 700"):
            read(path)
        monkeypatch.delenv(f"PEN_MHE_MOST_{name}")


def test_decimal_commas_between_commas_are_quoted() -> None:
    found = sniffed(['"a","b"', '"0,5","1,5"', '"0,6","1,7"'])
    assert found is not None
    assert (found.delimiter, found.columns, found.header) == (",", 2, ("a", "b"))
