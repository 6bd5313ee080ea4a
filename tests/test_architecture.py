"""The rules of the house that say who may know whom, and how large a part may be."""

from __future__ import annotations

import ast
import graphlib
from collections.abc import Mapping

import pytest

from tests.house import ROOT, imported, imports, lines, lines_in, modules, rooms
from tests.test_import_direction import FLOORS

LARGEST_ROOM, LARGEST_SUITE = 0.35, 0.10
"""Parts of the product's lines."""
LARGEST_BENCHMARK = 5000
LARGEST_FILE = 250
LARGER_FILES = {
    "estimation/observability.py": "the matrix and what is read from it",
    "suites/pen/figures.py": "one function a figure",
}
"""File above `LARGEST_FILE` → why it stays in one piece."""

MHE_ENTRANCES = {"mhe", "mhe.realtime", "mhe.window_loop"}
"""Modules on top of `mhe` that put its folders together; nothing else in the room imports them."""
MHE_FOLDERS: Mapping[str, set[str]] = {
    "compiled": set(),
    "interpreted": set(),
    "reference": set(),
    "sparse_qp": set(),
}
"""Folder of `mhe` → folders that it may import, beside itself and the files on top."""


def test_every_package_is_a_typed_room_on_a_floor() -> None:
    packages = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"tests"}
    floors = [room for floor in FLOORS for room in floor]
    assert packages == set(rooms()) == set(floors)
    assert len(floors) == len(set(floors))


def test_no_circle_of_files() -> None:
    """Imports in functions and for types count: two such files cannot be read one by one."""
    graphlib.TopologicalSorter(imports()).prepare()


def test_a_circle_would_be_found() -> None:
    code = ast.parse("def f():\n    from models.pen import pen_model\n    from mhe import config")
    assert imported(code, set(modules())) == {"models.pen", "mhe.config"}
    closed = imports() | {"models.errors": {"models.pen"}}
    with pytest.raises(graphlib.CycleError):
        graphlib.TopologicalSorter(closed).prepare()


def folder_of(module: str) -> str:
    """Return the second part of a module's name if it is a folder; empty on top of the room."""
    room, *rest = module.split(".")
    return rest[0] if rest and (ROOT / room / rest[0]).is_dir() else ""


def test_folders_of_mhe_know_the_top_and_not_each_other() -> None:
    against = {}
    for module in {name for name in modules() if name.split(".")[0] == "mhe"} - MHE_ENTRANCES:
        own = {name for name in imports()[module] if name.split(".")[0] == "mhe"}
        folder = folder_of(module)
        assert folder in {"", *MHE_FOLDERS}
        may = {"", folder} | MHE_FOLDERS.get(folder, set())
        against[module] = {name for name in own if folder_of(name) not in may} | own & MHE_ENTRANCES
    assert {module: wrong for module, wrong in against.items() if wrong} == {}


def suites() -> set[str]:
    return {path.parent.name for path in (ROOT / "suites").glob("*/__init__.py")}


def test_no_suite_imports_another() -> None:
    others = {
        (module, name)
        for module in modules()
        if module.startswith("suites.")
        for name in imports()[module]
        if name.startswith("suites.") and name.split(".")[1] in suites() - {module.split(".")[1]}
    }
    assert others == set()


def test_no_room_is_most_of_the_house() -> None:
    sizes = {room: lines_in(ROOT / room) for room in rooms()}
    whole = sum(sizes.values())
    assert {room: n for room, n in sizes.items() if n > LARGEST_ROOM * whole} == {}
    assert sizes["benchmark"] < LARGEST_BENCHMARK
    of_suites = {suite: lines_in(ROOT / "suites" / suite) for suite in suites()}
    assert {suite: n for suite, n in of_suites.items() if n > LARGEST_SUITE * whole} == {}


def test_files_are_small() -> None:
    large = {
        path.relative_to(ROOT).as_posix()
        for path in modules().values()
        if lines(path) > LARGEST_FILE
    }
    assert large == set(LARGER_FILES), "a new one is split; one that shrank leaves the table"
