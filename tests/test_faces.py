"""Faces of rooms: complete, lazy, and no name of theirs is that of a file."""

from __future__ import annotations

import ast
import inspect
import re
import subprocess
import sys
import textwrap
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from models.lazy import face_table
from tests.house import faces

ROOT = Path(__file__).resolve().parent.parent
STUBS = faces()
HEAVY = ("casadi", "numpy", "pydantic", "scipy", "pandas", "matplotlib")
pytestmark = pytest.mark.parametrize("room", STUBS)


def examples(doc: str) -> str:
    """Return the indented code of a docstring."""
    return "\n".join(
        textwrap.dedent(block) for block in re.findall(r"::\n\n((?:(?: {4}.*)?\n)+)", f"{doc}\n")
    )


def test_every_name_is_what_its_module_has(room: str) -> None:
    face = import_module(room)
    for name, (module, attribute) in face_table(STUBS[room]).items():
        found = getattr(face, name)
        if module == room:
            assert found is import_module(f"{room}.{name}")
        else:
            assert found is getattr(import_module(module), attribute)
    public = {name for name in face_table(STUBS[room]) if not name.startswith("_")}
    assert face.__all__ == sorted(public)
    assert public <= set(dir(face))


def test_the_stub_only_hands_names_on(room: str) -> None:
    """Type checkers take ``import a as a`` for a name of the stub's own."""
    for line in ast.parse(STUBS[room].read_text("utf-8")).body:
        assert isinstance(line, ast.ImportFrom)
        assert all(alias.asname == alias.name for alias in line.names), ast.unparse(line)


def test_no_file_has_the_name_of_what_the_face_offers(room: str) -> None:
    """Python would put the file in its place, whenever anything imports it."""
    files = {
        path.stem for path in STUBS[room].parent.iterdir() if path.suffix == ".py" or path.is_dir()
    }
    face = import_module(room)
    hidden = {name for name in face.__all__ if name in files}
    assert all(isinstance(getattr(face, name), ModuleType) for name in hidden), hidden


def test_nothing_is_imported_before_it_is_asked_for(room: str) -> None:
    code = f"import sys, {room}\nprint(*sorted(set({HEAVY!r}) & set(sys.modules)))"
    result = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert result.stdout.split() == []


def test_the_docstring_asks_a_question_and_shows_the_way_in(room: str) -> None:
    face = import_module(room)
    doc = inspect.cleandoc(face.__doc__ or "")
    assert doc.splitlines()[0].endswith("?")
    imports = [
        node
        for node in ast.walk(ast.parse(examples(doc)))
        if isinstance(node, ast.ImportFrom | ast.Import)
    ]
    assert imports
    for node in imports:
        if isinstance(node, ast.ImportFrom):
            assert {alias.name for alias in node.names} <= set(import_module(room).__all__)


def test_what_it_offers_says_what_it_is(room: str) -> None:
    face = import_module(room)
    for name in face.__all__:
        value = getattr(face, name)
        if inspect.isclass(value) or inspect.isfunction(value):
            assert value.__doc__, name
            assert not value.__doc__.startswith(f"{name}("), f"{name} has no docstring of its own"


def test_an_unknown_name_is_an_attribute_error(room: str) -> None:
    with pytest.raises(AttributeError, match=f"module '{room}' has no attribute 'nothing'"):
        import_module(room).nothing  # noqa: B018
    with pytest.raises(ImportError):
        exec(f"from {room} import nothing")
