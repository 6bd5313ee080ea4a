"""A pen file that a command writes: never the one, nor the recording, that it reads."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from estimation.apart import check_apart
from models.pen_file import pen_paths

SUFFIX = ".toml"


def check_pen_output(output: Path, pen: str, recordings: Iterable[Path]) -> None:
    """Refuse an output that is no pen file, cannot be written, or is read; makes nothing.

    Raises
    ------
    InputError
        If so; the message says what was expected.
    """
    from recordings.formats.tables import check_output  # tables are slow to import

    check_apart(
        [output],
        {
            "the pen file that is read, or a bundled one,": pen_paths(pen),
            "the recording": recordings,
        },
    )
    check_output(output, (SUFFIX,))
