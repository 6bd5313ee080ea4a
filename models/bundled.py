"""The data files that come with the package, and the names in them; nothing is built from them.

What completes a word on the command line needs names only, and at once.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

from models.errors import InputError
from models.parsed import toml_data
from models.plain_names import plain_name
from models.regular_files import read_text


@cache
def bundled_pens() -> Mapping[str, Path]:
    """Return the pen files that come with the package, by name."""
    folder = Path(str(resources.files("models"))) / "pens"
    return MappingProxyType({path.stem: path for path in sorted(folder.glob("*.toml"))})


@cache
def motion_rows() -> Mapping[str, Any]:
    """Return the rows of ``models/motions.toml`` by name, as they are written."""
    text = (resources.files("models") / "motions.toml").read_text("utf-8")
    return MappingProxyType(tomllib.loads(text))


def sensor_names(pen: str | Path) -> tuple[str, ...]:
    """Return the names of the sensors in a pen file or a bundled pen; none in no such file."""
    path = Path(pen)
    if str(pen) in bundled_pens() and not path.is_file():
        path = bundled_pens()[str(pen)]
    try:
        where = f"pen file {path}"
        text = read_text(path, where, "a readable TOML file", "toml_bytes")
        sensors = toml_data(text, where).get("sensors")
    except InputError:
        return ()
    return tuple(map(plain_name, sensors)) if isinstance(sensors, dict) else ()
