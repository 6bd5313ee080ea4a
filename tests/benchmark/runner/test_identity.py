"""What a finished task counts for: the code and the files it was run with."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmark.runner import identity
from benchmark.runner.identity import code_identity, folder_identity
from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Task
from models.errors import InputError
from pen_mhe.rooms import MARKS, rooms
from suites import execute
from suites.execute import task_identity


def tree(root: Path) -> Path:
    for name in (
        *("models/pen.py", "models/pen.toml", "models/notes.md", "benchmark/report/page.py"),
        *("commands/cli.py", "pyproject.toml"),
        *(f"{room}/{mark}" for room in ("models", "benchmark", "commands") for mark in MARKS),
    ):
        write(root / name, name)
    return root


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def identity_of(root: Path) -> str:
    """The identity of a tree as it is now."""
    rooms.cache_clear()
    return code_identity.__wrapped__(root)


def test_it_changes_with_what_results_depend_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tree(tmp_path)
    versions = dict.fromkeys(identity.LIBRARIES, "1")
    monkeypatch.setattr(identity, "version", versions.__getitem__)
    of_code = partial(identity_of, tmp_path)
    before = of_code()
    assert of_code() == before
    for name in ("models/notes.md", "benchmark/report/page.py", "commands/cli.py"):
        (tmp_path / name).write_text("changed")
        assert of_code() == before
    versions["pandas"] = "2"
    assert of_code() == before
    versions["numpy"] = "2"
    with_numpy = of_code()
    (tmp_path / "models/pen.toml").write_text("changed")
    with_pen = of_code()
    (tmp_path / "models/pen.py").rename(tmp_path / "models/pencil.py")
    assert len({before, with_numpy, with_pen, of_code()}) == 4


def test_a_new_room_and_an_edit_in_it_change_it(tmp_path: Path) -> None:
    tree(tmp_path)
    found = [identity_of(tmp_path)]
    write(tmp_path / "cellar" / "__init__.py", "")
    write(tmp_path / "cellar" / "shelf.py", "1")
    assert identity_of(tmp_path) == found[0]  # not typed, so no room: a folder of somebody's
    write(tmp_path / "cellar" / "py.typed", "")
    found.append(identity_of(tmp_path))
    write(tmp_path / "cellar" / "shelf.py", "2")
    found.append(identity_of(tmp_path))
    write(tmp_path / "cellar" / "deep" / "below.c", "3")
    found.append(identity_of(tmp_path))
    write(tmp_path / "models" / "pencil.py", "4")
    found.append(identity_of(tmp_path))
    assert len(set(found)) == 5


def test_a_folder_is_its_files(tmp_path: Path) -> None:
    of_folder = folder_identity.__wrapped__
    (tmp_path / "a").write_text("1")
    before = of_folder(tmp_path)
    (tmp_path / "below").mkdir()
    assert of_folder(tmp_path) == before
    (tmp_path / "below" / "b").write_text("1")
    with_b = of_folder(tmp_path)
    (tmp_path / "a").write_text("2")
    assert len({before, with_b, of_folder(tmp_path)}) == 3


def test_a_task_depends_on_the_recordings_that_it_reads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a").write_text("1")
    suite = SimpleNamespace(
        reads=lambda task: "real" if task.seed else "",
        made_of=lambda scope: "",
        is_timed=False,
    )
    monkeypatch.setattr(execute, "find_suite", lambda _: suite)
    reading, other = Task("s", "c", "n", "e", 1), Task("s", "c", "n", "e", 0)
    data = Scope(data=str(tmp_path))
    assert task_identity(other, data) == task_identity(reading, Scope()) == code_identity()
    assert task_identity(reading, data) == (
        f"{code_identity()}-{folder_identity.__wrapped__(tmp_path / 'real')}"
    )

    def unreadable(folder: Path) -> str:
        raise PermissionError(13, "Permission denied", str(folder / "a"))

    monkeypatch.setattr(identity, "folder_identity", unreadable)
    with pytest.raises(InputError, match=r"Permission denied: .*, expected readable files"):
        task_identity(reading, data)
