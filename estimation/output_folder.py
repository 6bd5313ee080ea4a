"""A folder for results, made before the work that would be lost."""

from __future__ import annotations

import tempfile
from pathlib import Path

from models.errors import InputError


def prepare_folder(folder: Path) -> None:
    """Make a folder, and try whether it can be written.

    Raises
    ------
    InputError
        If it cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"output {folder}: {error.strerror}, expected a folder that can be written"
        ) from None
