"""Every writer of the product leaves whole files, at whatever point of its work it ends.

Each is ended at every file operation that it makes, by an error and by SIGKILL, and by a limit in
the middle of its bytes; and there is no other writer.
"""

from __future__ import annotations

import ast
import os
import signal
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from benchmark.report import report
from benchmark.runner.about import write_about
from benchmark.runner.tables import write_tables
from benchmark.tasks.task import Task, failed
from codegen import folder as export_folder
from estimation.output_file import write_whole
from models.errors import InputError
from pen_mhe.figures import save
from recordings.formats.tables import write_table
from suites.speed.export import write_problem
from suites.speed.problems import PROBLEMS
from tests.estimation.test_named_columns import history
from tests.house import modules, tree
from tests.rooms_to_write import contents, room_for

Writer = Callable[[Path, int], object]
"""Writes something into a folder that depends on a number."""


def figure(path: Path, number: int) -> None:
    drawn, axes = plt.subplots(figsize=(1, 1))
    axes.plot([0, number])
    save(drawn, path)


def tables(folder: Path, number: int) -> None:
    outcomes = {Task("pen", "a", "accel", "ekf", number): failed("broken")}
    write_tables(outcomes, outcomes.__getitem__, folder)


def frame(number: int) -> pd.DataFrame:
    return pd.DataFrame({"time_s": np.arange(2000.0) + number})


def with_pages(folder: Path, number: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        for name in ("page", "terminal"):
            patch.setattr(report, name, lambda found: str(number) * 10_000)
        report.write_content(None, folder)  # type: ignore[arg-type]


def export(folder: Path, number: int) -> None:
    texts = {name: str(number) * 10_000 for name in ("pen.h", "pen.c", "README.md")}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(export_folder, "export_files", lambda *_: texts)
        export_folder.write_export(None, folder / "c", None, "")  # type: ignore[arg-type]


WRITERS: Mapping[str, Writer] = {
    "text": lambda folder, n: write_whole(folder / "pen.toml", str(n) * 10_000),
    "csv": lambda folder, n: write_table(frame(n), folder / "o.csv"),
    "parquet": lambda folder, n: write_table(frame(n), folder / "o.parquet"),
    "history": lambda folder, n: history()[: n + 1].to_csv(folder / "h.csv"),
    "png": lambda folder, n: figure(folder / "f.png", n),
    "run": lambda folder, n: write_about({"sessions": [n]}, folder),
    "tables": tables,
    "report": with_pages,
    "export": export,
    "problem": lambda folder, n: write_problem(PROBLEMS[0], {"a": np.arange(999) + n}, folder),
}
EVENTS = {"open", "os.rename", "os.remove", "os.mkdir", "os.chmod", "os.chown", "os.rmdir"}


def calls(work: Callable[[], object], at: int, then: Callable[[], None]) -> int:
    """Do something in this process, which a hook ends at a file operation; return how many."""
    count = 0

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal count
        if is_on and event in EVENTS and not str(arguments[0]).startswith(("/proc", sys.prefix)):
            count += 1
            if count == at:
                then()

    is_on = True
    sys.addaudithook(hook)
    try:
        work()
    finally:
        is_on = False
    return count


def killed(work: Callable[[], object], at: int) -> bool:
    """Do something in a child that SIGKILL ends at a file operation; whether it came that far."""
    child = os.fork()
    if not child:
        try:
            calls(work, at, lambda: os.kill(os.getpid(), signal.SIGKILL))
        finally:
            os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


def is_whole(
    found: Mapping[str, bytes], old: Mapping[str, bytes], new: Mapping[str, bytes]
) -> bool:
    """Whether each file is the old one or the new one, and none that was there is missing."""
    return found.keys() >= old.keys() and all(
        content in (old.get(name), new.get(name)) for name, content in found.items()
    )


def without_parts(found: Mapping[str, bytes]) -> dict[str, bytes]:
    return {name: content for name, content in found.items() if not name.endswith(".part")}


@pytest.fixture(scope="module", autouse=True)
def warm(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Whatever a writer imports when it is called first."""
    for writer in WRITERS.values():
        writer(tmp_path_factory.mktemp("warm"), 1)


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize(
    "is_new", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["old", "new"]
)
def test_sigkill_at_every_file_operation(name: str, is_new: bool, tmp_path: Path) -> None:
    folder, target = tmp_path / "folder", tmp_path / "target"
    folder.mkdir()
    target.mkdir()
    write = WRITERS[name]
    if not is_new:
        write(target, 1)
        write(folder, 1)
    old = contents(folder)
    write(target, 2)
    new = contents(target)
    at = 0
    while killed(lambda: write(folder, 2), at := at + 1):
        found = without_parts(contents(folder))
        assert is_whole(found, old, new), f"killed at {at}"
    assert at > 3
    write(folder, 2)  # what was left goes
    assert contents(folder).keys() == new.keys()


@pytest.mark.parametrize("name", WRITERS)
def test_a_limit_in_the_middle(name: str, tmp_path: Path) -> None:
    for is_old in (False, True):
        if is_old:
            WRITERS[name](tmp_path, 1)
        before = contents(tmp_path)
        with room_for(1), pytest.raises(InputError, match=r"output .*: File too large, exp"):
            WRITERS[name](tmp_path, 2)
        found = contents(tmp_path)
        found.pop("c", None)  # the folder of an export is made before
        assert found == {name: content for name, content in before.items() if name != "c"}


WRITES = {"write_text", "write_bytes", "savefig", "savez", "savez_compressed", "to_parquet"}
WRITES |= {"to_html", "write_html", "to_json", "to_pickle", "dump", "NamedTemporaryFile"}
MAY: Mapping[str, str] = {
    "estimation.output_file": "this is how",
    "estimation.compile_c": "a folder that goes",
    "estimation.native": "CasADi returns text",
    "codegen.sizes": "a folder that goes",
    "recordings.formats.bundles": "a folder that goes",
    "codegen.generated": "CasADi returns text",
    "pen_mhe.comparison": "to memory",
    "pen_mhe.figures": "to memory",
    "suites.speed.export": "to a whole file",
    "suites.speed.acados_library": "to nowhere",
    "benchmark.runner.journal": "lines are added",
}
"""Module that writes → why it may."""


def writes(node: ast.AST) -> bool:
    match node:
        case ast.Call(func=ast.Attribute(attr=name)) if name in WRITES:
            return True
        case ast.Call(func=ast.Name(id="open") | ast.Attribute(attr="open" | "fdopen")):
            given = [*node.args, *(keyword.value for keyword in node.keywords)]
            texts = {str(each.value) for each in given if isinstance(each, ast.Constant)}
            return any(set(text) & set("wax+") and set(text) <= set("rwaxbt+") for text in texts)
    return False


def test_there_is_no_other_writer() -> None:
    found = {name for name in modules() if any(writes(node) for node in ast.walk(tree(name)))}
    assert found == set(MAY)


def test_another_writer_would_be_seen() -> None:
    for code in ("p.write_text('x')", "open(p, 'w')", "p.open('ab')", "f.savefig(p)"):
        assert any(writes(node) for node in ast.walk(ast.parse(code)))
    for code in ("open(p)", "p.open('rb')", "open(p, encoding='utf-8')"):
        assert not any(writes(node) for node in ast.walk(ast.parse(code)))
