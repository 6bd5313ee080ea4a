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

SOURCES = [
    path
    for room in MAY_IMPORT
    for kind in ("*.py", "*.pyi")  # a face imports what its stub names
    for path in sorted((ROOT / room).rglob(kind))
]


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


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_follow_the_arrows(path: Path) -> None:
    room = path.relative_to(ROOT).parts[0]
    against = imported_rooms(path.read_text("utf-8"), room) - MAY_IMPORT[room] - {room}
    assert not against, f"{path.name} in {room} imports {against}"


def test_imports_inside_functions_are_seen() -> None:
    source = (
        "def f():\n    from mhe.config import x\n    importlib.import_module('recordings.ink')\n"
        "    import_module('suites.pen')"
    )
    assert imported_rooms(source, "models") == {"mhe", "recordings", "suites"}


def test_every_room_has_a_row() -> None:
    rooms = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"tests"}
    assert rooms <= set(MAY_IMPORT)
