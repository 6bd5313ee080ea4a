"""README, docs and notebooks import from the front door or from the face of a room."""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from models.lazy import face_table
from tests.house import faces, rooms
from tests.pages import PAGES as MARKDOWN
from tests.pages import SITE, of_language

ROOT = Path(__file__).resolve().parent.parent
FACES = {name: face_table(path) for name, path in faces().items()}
PAGES = sorted(
    [*MARKDOWN, *(ROOT / "notebooks").glob("*.ipynb")]
    + [path for path in (ROOT / "docs").rglob("*.py") if SITE not in path.parents]
)


PUBLIC = {"casadi", "IPython", "matplotlib", "numpy", "pandas", "scipy"}
"""What notebooks may import beside the product: its dependencies, and what runs a notebook."""


def code_of(path: Path) -> Iterator[str]:
    """Yield the Python of a page."""
    text = path.read_text("utf-8")
    match path.suffix:
        case ".py":
            yield text
        case ".md":
            yield from (block.text for block in of_language(path, "python"))
        case ".ipynb":
            for cell in json.loads(text)["cells"]:
                if cell["cell_type"] == "code":
                    lines = "".join(cell["source"]).splitlines()
                    yield "\n".join(line for line in lines if not line.startswith(("%", "!")))


def imports_past_the_door(source: str) -> set[str]:
    """Return modules of the product that code imports from, faces and what they offer aside."""
    past, doors = set(), {}
    nodes = list(ast.walk(ast.parse(source)))
    for node in nodes:
        match node:
            case ast.Import():
                for alias in node.names:
                    if alias.name in FACES:
                        doors[alias.asname or alias.name] = alias.name
                    else:
                        past.add(alias.name)
            case ast.ImportFrom(module=str(module)):
                for alias in node.names:
                    if alias.name not in FACES.get(module, ()):
                        past.add(f"{module}.{alias.name}" if module in FACES else module)
    for node in nodes:
        match node:
            case ast.Attribute(value=ast.Name(id=name)) if name in doors:
                if node.attr not in FACES[doors[name]] and not node.attr.startswith("__"):
                    past.add(f"{doors[name]}.{node.attr}")
    return {module for module in past if module.split(".")[0] in rooms()}


def past_the_door(path: Path) -> set[str]:
    """Return what a page imports past the door, as one program: an alias is for all cells."""
    return imports_past_the_door("\n".join(code_of(path)))


def test_every_kind_of_page_is_read() -> None:
    assert {path.suffix for path in PAGES} == {".md", ".py", ".ipynb"}
    assert all("import" in "\n".join(code_of(path)) for path in PAGES if path.suffix != ".md")
    assert "import" in "\n".join(code_of(ROOT / "README.md"))


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_pages_import_from_the_door_or_a_face(path: Path) -> None:
    past = past_the_door(path)
    assert not past, f"{path.name} imports {', '.join(sorted(past))}, expected a name of a face"


@pytest.mark.parametrize(
    "path", [path for path in PAGES if path.suffix == ".ipynb"], ids=lambda path: path.name
)
def test_notebooks_import_doors_and_what_is_installed_with_them(path: Path) -> None:
    """A copy of a notebook runs where the wheel and the extra [notebooks] are."""
    code = ast.parse("\n".join(code_of(path)))
    imported = {
        name.split(".")[0]
        for node in ast.walk(code)
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    }
    assert imported <= {*rooms(), *PUBLIC, *sys.stdlib_module_names}


@pytest.mark.parametrize(
    ("source", "past"),
    [
        ("import pen_mhe as pm\npm.load_pen('reference')\nprint(pm.__version__)", set()),
        ("from mhe import Mhe, MheConfig\nimport numpy.linalg", set()),
        ("from mhe.config import MheConfig", {"mhe.config"}),
        ("import mhe.config", {"mhe.config"}),
        ("from mhe import realtime", {"mhe.realtime"}),
        ("import pen_mhe as pm\npm.find_pen('reference')", {"pen_mhe.find_pen"}),
        ("def f():\n    from suites.table import find_suite", {"suites.table"}),
        ("from suites.tilt import CASES\nfrom suites import run_some", set()),
        ("from suites.tilt import recursion", {"suites.tilt.recursion"}),
        ("from benchmark import report", {"benchmark"}),
    ],
)
def test_imports_past_the_door_are_seen(source: str, past: set[str]) -> None:
    assert imports_past_the_door(source) == past
