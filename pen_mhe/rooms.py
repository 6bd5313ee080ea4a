"""Which packages the product is made of: found, not listed."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from models.errors import InputError

ROOT = Path(__file__).resolve().parent.parent
"""The folder that the rooms stand in: a checkout, or where packages are installed."""

DISTRIBUTION = "pen-mhe"
MARKS = ("__init__.py", "py.typed")
"""Files that every room has: a package, and a typed one. Tests are not typed for others."""


@cache
def rooms(root: Path = ROOT) -> tuple[str, ...]:
    """Return the names of the product's packages, in alphabetical order.

    In a checkout these are the folders with both `MARKS`; elsewhere, what the installed
    distribution says that it has, since others' packages stand beside them.

    Parameters
    ----------
    root : the folder that they stand in

    Raises
    ------
    InputError
        If it is no checkout and the distribution does not list its files.
    """
    if (root / "pyproject.toml").is_file():
        candidates = {path.parent.name for path in root.glob(f"*/{MARKS[1]}")}
        return tuple(sorted(name for name in candidates if (root / name / MARKS[0]).is_file()))
    try:
        listed = {path.parts for path in files(DISTRIBUTION) or ()}
    except PackageNotFoundError:
        listed = set()
    found = tuple(sorted(parts[0] for parts in listed if parts[1:] == (MARKS[1],)))
    if not found:
        raise InputError(
            f"{root} is no checkout, and no installed {DISTRIBUTION} lists its files, "
            "expected one of them"
        )
    return found
