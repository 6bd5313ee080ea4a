"""The rules of the house that say how code is written."""

from __future__ import annotations

import ast
import collections
import importlib
import re
from collections.abc import Iterator

import pytest

from models.sensor_kinds.table import KINDS, SENSOR_KINDS
from pen_mhe.estimators import ESTIMATORS
from tests.house import modules, rooms, tree

ERROR = "InputError"
WITHOUT_RAISES = "commands"
"""The room whose docstrings are the help of the terminal, and whose errors are exit codes."""

SPECIAL = {"__init__", "__post_init__", "__call__"}
"""Methods whose docstring is the class's."""

KINDS_ROOM = "models.sensor_kinds"
ASKS: dict[str, str] = {}
"""Module that asks for an estimator by its name → why it may."""

REFERENCE = re.compile(r"`([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+)`")


def in_room(room: str) -> list[str]:
    """Return the modules of a room."""
    return [module for module in modules() if module.split(".")[0] == room]


def definitions(module: str) -> Iterator[tuple[ast.AST, ast.FunctionDef | ast.ClassDef]]:
    """Yield (what it stands in, definition) of all that a module shows: no ``_`` on its way."""

    def inside(parent: ast.AST) -> Iterator[tuple[ast.AST, ast.FunctionDef | ast.ClassDef]]:
        for node in ast.iter_child_nodes(parent):
            if isinstance(node, ast.FunctionDef) and (
                not node.name.startswith("_") or node.name in SPECIAL
            ):
                yield parent, node
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                yield parent, node
                yield from inside(node)

    yield from inside(tree(module))


def raises(node: ast.AST) -> bool:
    """Whether a function raises `InputError` itself, not in a function within."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.ClassDef | ast.Lambda):
            continue
        if isinstance(child, ast.Raise) and child.exc and ERROR in ast.unparse(child.exc):
            return True
        if raises(child):
            return True
    return False


@pytest.mark.parametrize("room", sorted(set(rooms()) - {WITHOUT_RAISES}))
def test_whoever_raises_input_error_says_so(room: str) -> None:
    silent = []
    for module in in_room(room):
        for parent, node in definitions(module):
            if isinstance(node, ast.FunctionDef) and raises(node):
                said = ast.get_docstring(node) or ""
                if node.name in SPECIAL and isinstance(parent, ast.ClassDef):
                    said += ast.get_docstring(parent) or ""
                if ERROR not in said:
                    silent.append(f"{module}.{node.name}")
    assert not silent, f"raise {ERROR} and do not say so"


def test_class_names_are_unique() -> None:
    names = collections.Counter(
        node.name
        for module in modules()
        for node in ast.walk(tree(module))
        if isinstance(node, ast.ClassDef)
    )
    assert [name for name, count in names.items() if count > 1] == []


def fields_of(found: type) -> set[str]:
    """Return the fields of a class, whether or not they have a default."""
    return {field for base in found.__mro__ for field in vars(base).get("__annotations__", {})}


def resolves(reference: str) -> bool:
    """Whether a dotted name is a module, or something in one, as code would find it."""
    parts = reference.split(".")
    for split in range(len(parts), 0, -1):
        try:
            found: object = importlib.import_module(".".join(parts[:split]))
        except ImportError:
            continue
        for part in parts[split:]:
            if isinstance(found, type) and part in fields_of(found):
                return part == parts[-1]
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


@pytest.mark.parametrize("room", sorted(rooms()))
def test_references_resolve(room: str) -> None:
    """A back-ticked dotted name that begins with a room; others are code of their module."""
    found = {
        (module, name)
        for module in in_room(room)
        for name in REFERENCE.findall(modules()[module].read_text("utf-8"))
        if name.split(".")[0] in rooms()
    }
    wrong = {name for name in {name for _, name in found} if not resolves(name)}
    assert sorted((module, name) for module, name in found if name in wrong) == []


def test_a_wrong_reference_would_be_found() -> None:
    assert resolves("models.pen_config.PenConfig.sensors")
    assert resolves("estimation.status")
    assert not resolves("estimation.engine.Engine")
    assert not resolves("suites.table.SUITES")


def kind_classes() -> set[str]:
    return {kind.__name__ for kind in KINDS}


def asks_for_a_kind(code: ast.AST) -> list[str]:
    """Return the expressions that ask which kind a sensor is, or which estimator it is."""
    found = []
    for node in ast.walk(code):
        match node:
            case ast.Call(func=ast.Name(id="isinstance"), args=[_, classes]):
                asked = {n.id for n in ast.walk(classes) if isinstance(n, ast.Name)}
                if asked & kind_classes():
                    found.append(ast.unparse(node))
            case ast.MatchClass(cls=ast.Name(id=name)) if name in kind_classes():
                found.append(ast.unparse(node))
            case ast.Compare(left=left, comparators=comparators):
                sides = [left, *comparators]
                asked_for = {
                    side.attr if isinstance(side, ast.Attribute) else getattr(side, "id", "")
                    for side in sides
                }
                words = [word for side in sides for word in getattr(side, "elts", [side])]
                texts = {word.value for word in words if isinstance(word, ast.Constant)}
                is_attribute = any(isinstance(text, str) for text in texts) and (
                    asked_for & {"kind", "estimator"} and "dtype" not in ast.unparse(left)
                )
                if is_attribute or texts & {*ESTIMATORS, *SENSOR_KINDS}:
                    found.append(ast.unparse(node))
    return found


@pytest.mark.parametrize("room", sorted(rooms()))
def test_nothing_asks_which_sensor_or_estimator_it_is(room: str) -> None:
    asked = {
        module: asks_for_a_kind(tree(module))
        for module in in_room(room)
        if not module.startswith(KINDS_ROOM)
    }
    may = {module for module in ASKS if module in in_room(room)}
    assert {
        module: found for module, found in asked.items() if bool(found) != (module in may)
    } == {}


def test_a_question_for_a_kind_would_be_found() -> None:
    code = """
isinstance(sensor, (Contact, int))
sensor.kind == "own"
name == "mhe-sparse"
name in ("pose_camera", "other")
task.estimator in ("ekf", "mhe")
match sensor:
    case Gyroscope(): pass
"""
    assert len(asks_for_a_kind(ast.parse(code))) == 6


FACES = ("models", "estimation", "mhe", "ekf_baseline", "recordings", "codegen", "pen_mhe")
"""The rooms that people call from Python."""
KEYWORDS_FROM, MOST_POSITIONAL = 2, 5
ALGEBRA = "letters of one equation, in its order"
INSIDE = "called once, by its own room"
POSITIONAL = {
    "estimation.compiled_stage.CompiledStage.predict": ALGEBRA,
    "estimation.interpreted_stage.InterpretedStage.predict": ALGEBRA,
    "estimation.kalman_stage.KalmanStage.predict": ALGEBRA,
    "estimation.kalman_stage.KalmanStage.update": ALGEBRA,
    "estimation.report.report": INSIDE,
    "mhe.compiled.loop.CompiledWindow.__init__": INSIDE,
    "mhe.interpreted.descent.descend": INSIDE,
    "mhe.interpreted.loop.InterpretedWindow.__init__": INSIDE,
    "mhe.interpreted.window_pass.WindowPass.run": ALGEBRA,
    "mhe.sparse_qp.crossover.crossed_over": ALGEBRA,
}
"""Function that takes more by position than others may → why."""


def takes_too_much(node: ast.FunctionDef, is_method: bool) -> bool:
    """Whether more than five by position, or an option after the second parameter."""
    is_static = any(ast.unparse(decorator) == "staticmethod" for decorator in node.decorator_list)
    by_position = [*node.args.posonlyargs, *node.args.args][is_method and not is_static :]
    required = len(by_position) - len(node.args.defaults)
    has_late_option = bool(node.args.defaults) and len(by_position) > max(required, KEYWORDS_FROM)
    return len(by_position) > MOST_POSITIONAL or has_late_option


def test_options_are_keywords() -> None:
    found = set()
    for module in modules():
        if module.split(".")[0] not in FACES:
            continue
        for parent, node in definitions(module):
            if isinstance(node, ast.FunctionDef):
                stem = f"{module}.{parent.name}" if isinstance(parent, ast.ClassDef) else module
                if takes_too_much(node, isinstance(parent, ast.ClassDef)):
                    found.add(f"{stem}.{node.name}")
    assert found - set(POSITIONAL) == set(), "options after the second are keyword-only"
    assert set(POSITIONAL) - found == set(), "mended: leave the table"


@pytest.mark.parametrize(
    ("code", "is_method", "expected"),
    [
        ("def f(a, b=1): ...", False, False),
        ("def f(a, b, *, c=1): ...", False, False),
        ("def f(a, b, c=1): ...", False, True),
        ("def f(a, b=1, c=2): ...", False, True),
        ("def f(self, a, b=1): ...", True, False),
        ("def f(a, b, c, d, e, f): ...", False, True),
    ],
)
def test_too_many_positions_would_be_found(code: str, is_method: bool, expected: bool) -> None:
    (node,) = ast.parse(code).body
    assert isinstance(node, ast.FunctionDef)
    assert takes_too_much(node, is_method) is expected
