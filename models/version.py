"""The version of pen-mhe that made a file, and whether this one can read it."""

from __future__ import annotations

import re
from functools import cache
from importlib import metadata

from models.errors import InputError

VERSION_KEY = "pen_mhe_version"
"""Under which a pen file says with which version it was written, and a table's metadata too."""


@cache
def version() -> str:
    """Return the version of pen-mhe that runs."""
    return metadata.version("pen-mhe")


def version_metadata() -> dict[str, str]:
    """Return what the metadata of a Parquet file says of the version that wrote it."""
    return {VERSION_KEY: version()}


def check_version(written: object, where: str, *, running: str | None = None) -> None:
    """Refuse what a later series of versions has written: it may mean something else.

    A series is what stays compatible: ``1`` of 1.4.2, and ``0.2`` of 0.2.1.

    Parameters
    ----------
    written : version in the file: ``"0.2"`` or ``"0.2.1"``
    where : the file and its key, for the message
    running : the version that reads; None takes `version`

    Raises
    ------
    InputError
        If it is no version, or one of a later series.
    """
    if not isinstance(written, str) or not re.fullmatch(r"\d+(\.\d+){1,2}", written):
        raise InputError(f'{where}: {written!r} is no version, expected e.g. "0.2"')
    reads = running or version()
    if _series(written) > _series(reads):
        raise InputError(
            f"{where}: written by pen-mhe {written}, expected a version that pen-mhe {reads} "
            "knows: its own series or an earlier one"
        )


def _series(text: str) -> tuple[int, int]:
    major, minor = (int(part) for part in re.findall(r"\d+", text)[:2])
    return (major, minor if major == 0 else 0)
