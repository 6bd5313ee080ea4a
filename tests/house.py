"""The house as its tests see it: rooms, modules and who imports whom, found on disk."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@cache
def rooms() -> tuple[str, ...]:
    """Return the folders of the product: packages with types, in alphabetical order."""
    found = sorted(path.parent.name for path in ROOT.glob("*/py.typed"))
    return tuple(name for name in found if (ROOT / name / "__init__.py").is_file())


@cache
def faces() -> dict[str, Path]:
    """Return dotted name → stub, of every room and every suite that has a face."""
    stubs = sorted(path for room in rooms() for path in (ROOT / room).rglob("__init__.pyi"))
    return {".".join(path.parent.relative_to(ROOT).parts): path for path in stubs}


@cache
def modules() -> dict[str, Path]:
    """Return dotted name → file, of every module of the product."""
    found = {}
    for room in rooms():
        for path in sorted((ROOT / room).rglob("*.py")):
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            found[name.removesuffix(".__init__")] = path
    return found


@cache
def tree(module: str) -> ast.Module:
    return ast.parse(modules()[module].read_text("utf-8"))


def imported(code: ast.AST, known: set[str]) -> set[str]:
    """Return the known modules that code imports anywhere, in functions and for types too."""
    names: set[str] = set()
    for node in ast.walk(code):
        match node:
            case ast.Import():
                names.update(alias.name for alias in node.names)
            case ast.ImportFrom(level=0, module=str(module)):
                inside = {f"{module}.{alias.name}" for alias in node.names} & known
                names.update(inside)
                if len(inside) < len(node.names):
                    names.add(module)
            case ast.Call(
                func=ast.Attribute(attr="import_module") | ast.Name(id="import_module"),
                args=[ast.Constant(value=str(module)), *_],
            ):
                names.add(module)
    return names & known


@cache
def imports() -> dict[str, set[str]]:
    """Return module → modules of the product that it imports."""
    known = set(modules())
    return {name: imported(tree(name), known - {name}) for name in known}


def lines(path: Path) -> int:
    return len(path.read_text("utf-8").splitlines())


def lines_in(folder: Path) -> int:
    return sum(lines(path) for path in folder.rglob("*.py"))
