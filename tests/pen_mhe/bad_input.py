"""Bad input as data: how to make it, and what ``pen-mhe estimate`` must say to it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd
from typer.testing import CliRunner

from commands.cli import app
from models.bundled import bundled_pens
from models.pen_file import load_pen
from recordings.formats.dpoint import CAMERA_FILE, STYLUS_FILE
from recordings.formats.tables import recording_to_table
from recordings.simulate_pen import simulate

ACCEL = tuple(f"accel_{axis}_m_s2" for axis in "xyz")
GYRO = tuple(f"gyro_{axis}_rad_s" for axis in "xyz")
Writer = Callable[[Path], Path]
"""Takes an empty folder, writes a recording there, returns its path."""


@cache
def table() -> pd.DataFrame:
    """The reference pen's accelerometer and gyroscope along a slow stroke, with truth."""
    pen = load_pen("reference")
    recording = simulate(pen, ["accel", "gyro"], motion="turn", duration_s=6.0, seed=1, speed=0.5)
    return recording_to_table(recording, pen)


def text(edit: Callable[[str], str], name: str = "pen.csv") -> Writer:
    """A file of the good table's edited text."""

    def write(folder: Path) -> Path:
        (folder / name).write_text(edit(table().to_csv(index=False)))
        return folder / name

    return write


def csv(edit: Callable[[pd.DataFrame], pd.DataFrame]) -> Writer:
    """A CSV file of an edited table."""
    return text(lambda _: edit(table().copy()).to_csv(index=False))


def parquet(edit: Callable[[pd.DataFrame], pd.DataFrame]) -> Writer:
    """A Parquet file of an edited table."""

    def write(folder: Path) -> Path:
        edit(table().copy()).to_parquet(folder / "pen.parquet", index=False)
        return folder / "pen.parquet"

    return write


def cell(row: int, column: str, content: str) -> Writer:
    """A CSV file with something in one cell; row 1 lies below the header."""

    def edit(rows: str) -> str:
        lines = rows.splitlines()
        cells = lines[row].split(",")
        cells[lines[0].split(",").index(column)] = content
        lines[row] = ",".join(cells)
        return "\n".join(lines)

    return text(edit)


def longer(first: int, last: int) -> Writer:
    """A CSV file with rows that have a cell too many."""

    def edit(rows: str) -> str:
        lines = enumerate(rows.splitlines())
        return "\n".join(line + ",5" * (first <= row <= last) for row, line in lines)

    return text(edit)


def in_other_unit(columns: tuple[str, ...], factor: float, old: str = "", new: str = "") -> Writer:
    """A CSV file with columns times a factor, and another unit in their headers."""

    def edit(rows: pd.DataFrame) -> pd.DataFrame:
        rows[list(columns)] *= factor
        return rows.rename(columns={name: name.replace(old, new) for name in columns})

    return csv(edit)


def dpoint(
    change: Callable[[list[Any], list[Any]], object] = lambda stylus, camera: None,
) -> Writer:
    """A D-POINT folder of three samples and two frames, changed."""

    def write(folder: Path) -> Path:
        stylus = [
            {"t": t, "data": {"t": t, "accel": [0, 0, 9.8], "gyro": [0, 0, 0], "pressure": 0.1}}
            for t in (100, 108, 116)
        ]
        eye = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        camera = [
            {"t": t, "data": {"position": [[0], [0], [0]], "orientation_mat": eye}}
            for t in (150, 183)
        ]
        change(stylus, camera)
        (folder / STYLUS_FILE).write_text(json.dumps(stylus))
        (folder / CAMERA_FILE).write_text(json.dumps(camera))
        return folder

    return write


def good(folder: Path) -> Path:
    return csv(lambda rows: rows)(folder)


@dataclass(frozen=True)
class Case:
    """Bad input.

    Parameters
    ----------
    parts : what the message must contain, in this order
    recording : writes the recording; a good one by default
    replace : text of the reference pen's file and what stands there instead
    pen, options : of the command
    """

    parts: tuple[str, ...]
    recording: Writer = good
    replace: tuple[str, str] | None = None
    pen: str = "reference"
    options: tuple[str, ...] = ()


def estimate(case: Case, folder: Path) -> Any:
    """Call ``pen-mhe estimate`` as the case says."""
    pen = case.pen
    if case.replace is not None:
        toml = bundled_pens()["reference"].read_text()
        assert case.replace[0] in toml
        pen = str(folder / "my.toml")
        Path(pen).write_text(toml.replace(*case.replace, 1))
    arguments = ["estimate", str(case.recording(folder)), "--pen", pen, *case.options]
    return CliRunner().invoke(app, [*arguments, "--output", str(folder / "o.csv")])


def check_sentence(case: Case, folder: Path) -> None:
    """One sentence on stderr with the case's parts, and exit status 2."""
    result = estimate(case, folder)
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    message = result.stderr.removesuffix("\n")
    assert message.startswith("pen-mhe: ")
    # One line, one sentence: no full stop that another sentence follows.
    assert re.search(r"\n|[.!?]\s+[A-Z]|Traceback", message) is None
    end = 0
    for part in case.parts:
        start = message.find(part, end)
        assert start >= 0, f"{part!r} is not at its place in {message!r}"
        end = start + len(part)
