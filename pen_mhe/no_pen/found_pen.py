"""A pen that was found in a recording, and its file."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

from estimation.output_file import write_whole
from models.errors import InputError
from models.pen_config import PenConfig
from models.regular_files import read_text
from recordings.finding import Finding
from recordings.read import RecordingPath

MARK = "# as written: "
"""Begins the last line of the file: an edited one no longer fits it, and is not written over."""


@dataclass(frozen=True, eq=False, repr=False)
class FoundPen:
    """What `pen_mhe.no_pen.pen_for.pen_for` returns; prints itself as sentences.

    Parameters
    ----------
    pen : for an estimate
    text : of a pen file that says the same, with where each number comes from
    notes : sentences on what was measured and what is assumed
    findings : what an estimate may suffer from
    """

    pen: PenConfig
    text: str
    notes: tuple[str, ...]
    findings: tuple[Finding, ...] = ()

    def to_toml(self) -> str:
        """Return the pen file."""
        return f"{self.text}\n{_mark(self.text)}\n"

    def write(self, path: str | Path) -> None:
        """Write the pen file; one that is there stays if somebody has edited it.

        Raises
        ------
        InputError
            If it is not this project's own, was edited, or the file cannot be written.
        """
        check_not_edited(path)
        write_whole(path, self.to_toml())

    def __repr__(self) -> str:
        return "\n".join([self.pen.name, *self.notes])


def place_of(recording: RecordingPath, output: Path) -> Path:
    """Return where the pen file of a recording goes: ``<recording>_pen.toml`` beside an output."""
    first = recording if isinstance(recording, str | Path) else next(iter(recording))
    name = Path(os.path.abspath(first)).name
    return output.parent / f"{name.split('.')[0] or name}_pen.toml"


def check_not_edited(path: str | Path) -> None:
    """Refuse to write over a pen file that somebody has edited, or that is another's.

    Raises
    ------
    InputError
        If so; the message says what to do.
    """
    if not Path(path).exists():
        return
    text = read_text(Path(path), f"output {path}", "a pen file", "toml_bytes")
    body, _, mark = text.rstrip("\n").rpartition("\n")
    if mark != _mark(body):
        raise InputError(
            f"output {path}: the pen file is there and was edited, expected --pen {path} to "
            "estimate with it, or that it is moved away to find one anew"
        )


def _mark(text: str) -> str:
    return MARK + hashlib.sha256(text.strip("\n").encode()).hexdigest()[:12]
