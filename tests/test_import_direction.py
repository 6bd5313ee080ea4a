"""Imports follow the arrows of the house, inside functions too."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FLOORS: tuple[tuple[str, ...], ...] = (
    ("models",),
    ("estimation",),
    ("mhe", "ekf_baseline", "classical_baseline", "recordings"),
    ("codegen",),
    ("pen_mhe",),
    ("benchmark",),
    ("suites",),
    ("commands",),
)
"""Rooms from the ground up: a room imports from floors below its own."""

MAY_IMPORT = {
    room: {below for lower in FLOORS[:level] for below in lower}
    for level, floor in enumerate(FLOORS)
    for room in floor
}
"""Room → rooms that it may import, itself aside."""


def imported_rooms(source: str, package: str) -> set[str]:
    """Return the rooms that a module imports anywhere in its code."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Import():
                names.update(alias.name.split(".")[0] for alias in node.names)
            case ast.ImportFrom():
                names.add(package if node.level else (node.module or "").split(".")[0])
            case ast.Call(
                func=ast.Attribute(attr="import_module")
                | ast.Name(id="__import__" | "import_module")
            ):
                names.update(
                    str(argument.value).split(".")[0]
                    for argument in node.args
                    if isinstance(argument, ast.Constant)
                )
    return names & (set(MAY_IMPORT) | {"tests"})


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_imports_follow_the_arrows(room: str) -> None:
    sources = [path for kind in ("*.py", "*.pyi") for path in sorted((ROOT / room).rglob(kind))]
    assert sources, "a face imports what its stub names"
    found = {path: imported_rooms(path.read_text("utf-8"), room) for path in sources}
    may = MAY_IMPORT[room] | {room}
    assert {path: rooms - may for path, rooms in found.items() if rooms - may} == {}


def test_imports_inside_functions_are_seen() -> None:
    source = (
        "def f():\n    from mhe.config import x\n    importlib.import_module('recordings.ink')\n"
        "    import_module('suites.pen')"
    )
    assert imported_rooms(source, "models") == {"mhe", "recordings", "suites"}


def test_every_room_has_a_row() -> None:
    rooms = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"tests"}
    assert rooms <= set(MAY_IMPORT)
