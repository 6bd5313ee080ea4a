"""Which version of pen-mhe this is."""

from __future__ import annotations

import tomllib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PYPROJECT = Path(__file__).resolve().parent.parent / "pyproject.toml"


def _version() -> str:
    """Return the checkout's version, else that of the installed distribution."""
    if PYPROJECT.is_file():
        found: str = tomllib.loads(PYPROJECT.read_text("utf-8"))["project"]["version"]
        return found
    try:
        return version("pen-mhe")
    except PackageNotFoundError:
        return "unknown"


__version__ = _version()
