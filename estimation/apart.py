"""What is written is nothing that is read: by the file itself, whatever its names and links."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from models.errors import InputError


def check_apart(
    outputs: Iterable[Path | None], inputs: Mapping[str, Iterable[Path | None]]
) -> None:
    """Refuse to write over what is read, or two results to one file.

    Parameters
    ----------
    outputs : files that are to be written; None is none
    inputs : what is read, in words → its files and folders; None is none

    Raises
    ------
    InputError
        If an output is a file of an input, or another output.
    """
    read = {
        which: what
        for what, paths in inputs.items()
        for path in paths
        if path is not None
        for which in _files(path)
    }
    written: dict[tuple[int, int] | Path, Path] = {}
    for output in outputs:
        if output is None:
            continue
        which = _file(output) or output.resolve()
        if which in read:
            raise InputError(
                f"output {output} is {read[which]} itself, expected another file: it would be lost"
            )
        other = written.setdefault(which, output)
        if other is not output:
            raise InputError(f"outputs {other} and {output} are one file, expected two")


def _files(path: Path) -> Iterator[tuple[int, int]]:
    """Yield what identifies each file of an input."""
    if found := _file(path):
        yield found
    for folder, _, names in os.walk(path):
        for name in names:
            if found := _file(Path(folder, name)):
                yield found


def _file(path: Path) -> tuple[int, int] | None:
    """Return device and number of a file that is there, behind whatever links."""
    with contextlib.suppress(OSError):
        state = path.stat()
        return state.st_dev, state.st_ino
    return None
