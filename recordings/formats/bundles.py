"""Several files that are one recording: a folder or a .zip of tables, as phones' loggers write.

phyphox and Sensor Logger write a file a sensor, at its own rate, with stamps of one clock.
"""

from __future__ import annotations

import csv
import shutil
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Protocol

from models.errors import InputError
from models.limits import check_most
from models.regular_files import open_regular
from models.shown_text import one_line
from recordings.foreign.source_table import SourceTable
from recordings.formats.dpoint import CAMERA_FILE, STYLUS_FILE
from recordings.formats.json_tables import JSON_SUFFIXES
from recordings.formats.text_tables import TEXT_SUFFIXES

ZIP_SUFFIXES = (".zip",)
EXPECTED = "tables of one recording"
METADATA, _LARGEST_ABOUT = "Metadata.csv", 100_000
_SUFFIXES = (*TEXT_SUFFIXES, *JSON_SUFFIXES, ".parquet")


class Parse(Protocol):
    """Reads the tables of a file of any format."""

    def __call__(
        self, path: Path, where: str, /, *, header: Sequence[str] | None = None
    ) -> list[SourceTable] | None:
        """Return the tables; None where it is of no format."""


def read_folder(
    path: Path, where: str, *, header: Sequence[str] | None, parse: Parse
) -> list[SourceTable]:
    """Read the tables of a folder; what is none is left out.

    Raises
    ------
    InputError
        If none of its files is a table.
    """
    files = sorted(one for one in path.rglob("*") if one.is_file() and one.name[0] != ".")
    check_most("members", len(files), where)
    about = _about(files)
    found: list[SourceTable] = []
    refused: list[str] = []
    for file in files:
        name = file.relative_to(path).as_posix()
        try:
            found += parse(file, f"{where}: {name}", header=header) or []
        except InputError as error:
            refused.append(str(error))
    if not found:
        reason = f" ({refused[0]})" if refused else ""
        raise InputError(
            f"{where} is a folder without D-POINT's files, and no file of it is a table{reason}, "
            f"expected {STYLUS_FILE} and {CAMERA_FILE}, or {EXPECTED}"
        )
    return [replace(table, about=about) for table in found]


def _about(files: Sequence[Path]) -> str:
    """Return what Sensor Logger's file says of all others: ``platform=ios, version=3, …``."""
    for file in files:
        if file.name == METADATA and file.stat().st_size < _LARGEST_ABOUT:
            rows = list(csv.reader(file.read_text("utf-8", "replace").splitlines()))
            if len(rows) > 1:
                return one_line(", ".join(sorted(map("=".join, zip(*rows[:2], strict=False)))))
    return ""


def read_zip(
    path: Path, where: str, *, header: Sequence[str] | None, parse: Parse
) -> list[SourceTable]:
    """Read the tables of an archive.

    Raises
    ------
    InputError
        If it cannot be unpacked, is larger than `models.limits.LIMITS` allows, or `read_folder`
        refuses what is in it.
    """
    with (
        tempfile.TemporaryDirectory(prefix="pen-mhe-") as scratch,
        open_regular(path, where, EXPECTED, "table_bytes") as file,
    ):
        folder = Path(scratch)
        try:
            with zipfile.ZipFile(file) as archive:
                _unpack(archive, folder, where)
        except InputError:
            raise
        except Exception as error:  # whatever a damaged archive makes of itself
            raise InputError(f"{where}: cannot be unpacked, expected {EXPECTED}") from error
        return read_folder(folder, where, header=header, parse=parse)


def _unpack(archive: zipfile.ZipFile, folder: Path, where: str) -> None:
    """Unpack the tables of an archive; a name never leads out of the folder."""
    members = [one for one in archive.infolist() if not one.is_dir()]
    check_most("members", len(members), where)
    check_most("unpacked_bytes", sum(one.file_size for one in members), where)
    for member in members:
        name = PurePosixPath(member.filename)
        if name.suffix.casefold() not in _SUFFIXES or "__MACOSX" in name.parts:
            continue
        target = folder / "/".join(part for part in name.parts if part not in ("..", "/"))
        target.parent.mkdir(parents=True, exist_ok=True)
        with archive.open(member) as packed, target.open("wb") as file:
            shutil.copyfileobj(packed, file)
