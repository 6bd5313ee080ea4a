"""Faces of rooms: names that are imported when somebody first asks for them.

The names of a face and the modules that they come from stand in its stub ``__init__.pyi``
and nowhere else: a type checker reads there what Python imports here (PEP 562).
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple


class Face(NamedTuple):
    """What a room's ``__init__.py`` makes its own."""

    get: Callable[[str], Any]
    names: Callable[[], list[str]]
    public: list[str]


def lazy_face(package: str, file: str) -> Face:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a room.

    Parameters
    ----------
    package, file : ``__name__`` and ``__file__`` of its ``__init__.py``
    """
    table = face_table(Path(file).with_suffix(".pyi"))

    def get(name: str) -> Any:
        room = sys.modules[package]
        if name not in table:
            # Name and object let Python ask "did you mean".
            raise AttributeError(
                f"module {package!r} has no attribute {name!r}", name=name, obj=room
            )
        module, attribute = table[name]
        found = (
            import_module(f"{package}.{attribute}")
            if module == package
            else getattr(import_module(module), attribute)
        )
        # Python looks here first: the next time costs nothing.
        setattr(room, name, found)
        return found

    def names() -> list[str]:
        own = vars(sys.modules[package])
        return sorted({*table, *(name for name in own if name.startswith("__"))})

    return Face(get, names, sorted(name for name in table if not name.startswith("_")))


def face_table(stub: Path) -> Mapping[str, tuple[str, str]]:
    """Return name → (module, name there) of a stub that only imports.

    A name that comes from the room itself is a module of it.
    """
    lines = ast.parse(stub.read_text("utf-8")).body
    return MappingProxyType(
        {
            alias.asname or alias.name: (line.module or "", alias.name)
            for line in lines
            if isinstance(line, ast.ImportFrom)
            for alias in line.names
        }
    )
